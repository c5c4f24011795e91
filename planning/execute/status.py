"""ExecutionStatus: state, progress and tracking error of an execution at one instant."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.touching_pair import TouchingPair
from planning.domain.scene.held_pose import HeldPose
from planning.domain.value import Value
from planning.errors import ExecutionFailure
from planning.execute.states import ExecutionState


@dataclass(frozen=True, eq=False)
class ExecutionStatus(Value):
    """State, progress and tracking error of an execution at one instant.

    Attributes:
        state: State of the state machine.
        progress: Share of the path's length that is done, 0 to 1 (`path_fraction`).
        time: Time along the trajectory [s].
        driver_time: Time on the driver's clock, since the start [s].
        path_velocity: Seconds of trajectory per second of the driver's clock, at this instant;
            negative is backwards.
        measured: Positions of the group, shape (nq,).
        velocities: Measured velocities of the group, shape (nv,).
        torques: Measured torques or forces of its motors [N m or N], shape (nv,); None if unknown.
        desired: Desired positions of the group, shape (nq,).
        tracking_error: Largest coordinate of `measured [-] desired` [rad or m].
        contacts: Body pairs in contact since the previous tick, deepest first.
        failure: Reason of an abort, or None.
        ahead: Place that it does not pass forwards, time along the trajectory [s]; None for none.
        behind: Place that it does not pass backwards [s]; None for none.
        held: Where the objects are that are held by contact, where that is measured.
    """

    state: ExecutionState
    progress: float
    time: float
    driver_time: float
    path_velocity: float
    measured: Float64[np.ndarray, " nq"]
    velocities: Float64[np.ndarray, " nv"]
    torques: Float64[np.ndarray, " nv"] | None
    desired: Float64[np.ndarray, " nq"]
    tracking_error: float
    contacts: tuple[TouchingPair, ...]
    failure: ExecutionFailure | None
    ahead: float | None = None
    behind: float | None = None
    held: tuple[HeldPose, ...] = ()
