"""ExecutionStatus: state, progress and tracking error of an execution at one instant."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.value import Value
from planning.errors import ExecutionFailure
from planning.execute.states import ExecutionState


@dataclass(frozen=True, eq=False)
class ExecutionStatus(Value):
    """State, progress and tracking error of an execution at one instant.

    Attributes:
        state: State of the state machine.
        progress: Time along the trajectory over its duration, 0 to 1.
        time: Time along the trajectory [s].
        driver_time: Time on the driver's clock, since the start [s].
        path_velocity: Seconds of trajectory per second of the driver's clock, at this instant.
        measured: Positions of the group, shape (nq,).
        desired: Desired positions of the group, shape (nq,).
        tracking_error: Largest coordinate of `measured [-] desired` [rad or m].
        contacts: Body pairs in contact since the previous measurement.
        failure: Reason of an abort, or None.
    """

    state: ExecutionState
    progress: float
    time: float
    driver_time: float
    path_velocity: float
    measured: Float64[np.ndarray, " nq"]
    desired: Float64[np.ndarray, " nq"]
    tracking_error: float
    contacts: tuple[BodyPair, ...]
    failure: ExecutionFailure | None
