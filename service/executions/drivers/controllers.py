"""Controllers of robots that executions may drive: those in the server's settings alone."""

from collections.abc import Mapping

from planning.errors import ProblemInvalid, UnknownName
from service.api.names import located
from service.executions.requests import ExecutionRequest, UrRtdeDriver
from service.executions.tasks import ExecutionOutline
from service.jobs.job import JobSummary
from service.scenes.models.summary import Group

# What a controller of Universal Robots moves.
_UR_JOINTS = ["revolute"] * 6


def address_of(request: ExecutionRequest, hosts: Mapping[str, str]) -> str | None:
    """Return the address of the controller that a request names; None if it needs none.

    Raises:
        UnknownName: The settings have no controller of that name.
    """
    if not isinstance(request.driver, UrRtdeDriver):
        return None
    name = request.driver.host
    if name not in hosts:
        fault = UnknownName.among("controller", name, hosts)
        raise located(fault, {"driver": {"host": name}})
    return hosts[name]


def check_driven(driver: str | UrRtdeDriver, group: Group) -> None:
    """Check that a driver can move a group.

    Raises:
        ProblemInvalid: The group has other joints than the robots of the driver.
    """
    kinds = [str(joint.type) for joint in group.joints]
    if isinstance(driver, UrRtdeDriver) and kinds != _UR_JOINTS:
        message = f"driver: a UR controller moves six revolute joints, {group.name} has {kinds}"
        raise ProblemInvalid(message, {"field": "driver"})


def check_speed(job: JobSummary, speed: float) -> None:
    """Check that an execution can have a speed.

    Raises:
        ProblemInvalid: It is beyond 1, and the robot has no clock that could run faster.
    """
    driver = ExecutionOutline.model_validate(job.payload).request.driver
    if isinstance(driver, UrRtdeDriver) and abs(speed) > 1:
        message = f"speed: a robot can have at least -1 and at most 1, got {speed:g}"
        raise ProblemInvalid(message, {"field": "speed"})
