"""Where a robot has to be to be moved: at the start of the motion, at rest, and known to be."""

import math

from planning.domain.robot.joints import Joint, JointType
from service.errors import RobotStateUnknown, StartMismatch
from service.executions.models import ExecutionStatus
from service.executions.tasks import START_TOLERANCE, ExecutionOutcome
from service.jobs.job import JobSummary
from service.jobs.service import JobService
from service.scenes.live import RobotStatus
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord


def check_at_start(group: Group, start: list[float]) -> None:
    """Check that the group is at the start of a motion.

    Raises:
        StartMismatch: It is elsewhere.
    """
    positions: list[float] = group.positions
    distance = joint_distance(group, start, positions)
    if distance > START_TOLERANCE:
        message = (
            f"the motion starts {distance:.4g} rad or m from where {group.name} is; "
            "plan from `positions` instead"
        )
        evidence = {
            "start": start,
            "positions": positions,
            "distance": distance,
            "bound": START_TOLERANCE,
            "names": group.position_names,
        }
        raise StartMismatch(message, evidence)


def require_known(record: SceneRecord) -> None:
    """Go on only if it is known where every robot of a scene is: motions are proven beside them.

    Raises:
        RobotStateUnknown: A driver has lost its robot.
    """
    lost = [state for state in record.live.values() if state.status is RobotStatus.UNKNOWN]
    if lost:
        robots = sorted(state.robot for state in lost)
        message = (
            f"it is not known where {', '.join(robots)} is, since an execution ended without its "
            "driver; look at the robot, and say where it is by `set_positions`"
        )
        raise RobotStateUnknown(message, {"robots": robots})


async def last_status(jobs: JobService, job: JobSummary) -> ExecutionStatus | None:
    """Return the last status of an execution, None if it never moved."""
    if job.result is not None:
        return ExecutionOutcome.model_validate(job.result).status
    latest = await jobs.latest_event(job, "status")
    return None if latest is None else ExecutionStatus.model_validate(latest)


def joint_distance(group: Group, a: list[float], b: list[float]) -> float:
    """Return the largest coordinate of the difference [rad or m], whole turns aside."""
    largest = 0.0
    at = 0
    for joint in group.joints:
        kind = Joint(joint.name, JointType(joint.type))
        count = len(kind.position_names)
        largest = max(largest, _joint_distance(kind.type, a[at : at + count], b[at : at + count]))
        at += count
    return largest


def _joint_distance(kind: JointType, a: list[float], b: list[float]) -> float:
    gaps = [abs(x - y) for x, y in zip(a, b, strict=True)]
    match kind:
        case JointType.CONTINUOUS:
            return _turn(gaps[0])
        case JointType.PLANAR:
            return max(*gaps[:2], _turn(gaps[2]))
        case JointType.FLOATING:
            cosine = abs(sum(x * y for x, y in zip(a[:4], b[:4], strict=True)))
            return max(2 * math.acos(min(1.0, cosine)), *gaps[4:])
        case _:
            return max(gaps)


def _turn(gap: float) -> float:
    """Return an angle's distance from the nearest whole turn."""
    return abs(math.remainder(gap, 2 * math.pi))
