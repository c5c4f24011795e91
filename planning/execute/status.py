"""ExecutionStatus: how an execution goes, at one instant."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.value import Value
from planning.errors import ExecutionFailure
from planning.execute.states import ExecutionState


@dataclass(frozen=True, eq=False)
class ExecutionStatus(Value):
    """How an execution goes, at one instant.

    Attributes:
        state: Where it stands.
        progress: Time along the trajectory over its duration, 0 to 1.
        time: Along the trajectory [s].
        clock: On the driver's clock, since the start [s].
        rate: Seconds of trajectory per second of the driver's clock, at this instant.
        measured: Positions of the group, shape (nq,).
        desired: Positions that the group should have, shape (nq,).
        tracking_error: Largest coordinate of `measured [-] desired` [rad or m].
        contacts: What has touched since the status before.
        failure: Why it was aborted, or None.
    """

    state: ExecutionState
    progress: float
    time: float
    clock: float
    rate: float
    measured: Float64[np.ndarray, " nq"]
    desired: Float64[np.ndarray, " nq"]
    tracking_error: float
    contacts: tuple[BodyPair, ...]
    failure: ExecutionFailure | None
