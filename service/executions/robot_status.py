"""What a driver leaves behind: whether its robot is known to rest once an execution has ended."""

from collections.abc import Mapping
from typing import Any

from service.executions.models import ExecutionState
from service.executions.requests import UrRtdeDriver, rests_when_lost
from service.scenes.live import RobotStatus

# Code of a failure by which a driver says that it has lost its robot, and whether that `rests`.
_LOST = "driver_lost"
_ENDED = {ExecutionState.SUCCEEDED, ExecutionState.CANCELED, ExecutionState.ABORTED}


def status_after(
    driver: str | UrRtdeDriver, last: ExecutionState, failure: Mapping[str, Any] | None
) -> RobotStatus:
    """Return the status of a robot whose execution has ended.

    Args:
        driver: That moved it.
        last: State that the driver told last: one that is not final if the driver died.
        failure: That the execution ended with, if with one: its `code` and `evidence`.
    """
    is_known = last in _ENDED or rests_when_lost(driver)
    if failure is not None and failure["code"] == _LOST:
        is_known = bool(failure["evidence"].get("rests"))
    return RobotStatus.AT_REST if is_known else RobotStatus.UNKNOWN
