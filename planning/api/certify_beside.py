"""certify_beside(): proof that a motion may be executed beside others, whatever the timing."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from planning.api.certify_trajectory import validate_motion
from planning.certify.beside.beside_check import check_beside
from planning.certify.beside.beside_request import BesideRequest, moved_bodies
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.report.beside_report import BesideCheck, BesideOutcome, BesideReport
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.errors import ProblemInvalid
from planning.world.world import World

type GroupTrajectory = tuple[str, TimedTrajectory]

_OUTCOMES = {
    "PROVEN": BesideOutcome.PROVEN,
    "TOO_NEAR": BesideOutcome.VIOLATED,
    "UNPROVEN": BesideOutcome.UNDECIDED,
}


def certify_beside(
    world: World,
    motion: GroupTrajectory,
    others: Sequence[GroupTrajectory],
    *,
    deadline: Deadline,
    margin: float | None = None,
) -> BesideReport:
    """Prove that a motion keeps its margins beside others, at any times of all of them.

    For executions that are started, paused, slowed or driven backwards one by one: at every instant
    of the motion and, independently, every instant of each other motion, every pair of bodies of
    which one is moved by the motion and one by the other keeps its margin. Attached objects are
    moved by the group that carries them. What is left of a motion is enough: `trajectory.after(t)`;
    a robot at rest is `TimedTrajectory.at_rest(joints, q)`. The method is explained in
    `planning.certify.beside.beside_check`.

    Not proven here: each motion alone, as by `certify_trajectory`; the others beside each other.

    Args:
        world: Loaded scene, with what is attached; joints outside of all groups stay where it has
            them.
        motion: Group, `robot` or `robot::group`, and its exact motion.
        others: Groups and motions beside which it is executed.
        deadline: Time limit.
        margin: Required distance of bodies [m]; None for the scene's. Exceptions for pairs stay.

    Returns:
        A check for each other motion, up to the first that is not proven. The order of the two
        motions of a check does not matter.

    Raises:
        UnknownName: There is no such group.
        ProblemInvalid: A trajectory is of other joints or malformed, or two groups move one body.
        DeadlineExceeded: Time ran out.
        Canceled: Cancellation was requested.
        ModelInvalid: The scene has a shape or joint of a kind that cannot be certified.
    """
    fields = ["motion", *(f"others.{i}" for i in range(len(others)))]
    groups = [
        _validated(world, field, *each)
        for field, each in zip(fields, (motion, *others), strict=True)
    ]
    bodies = [moved_bodies(world.drake, group) for group in groups]
    _validate_apart(fields, groups, bodies)
    margins = world.margins(margin)
    checks: list[BesideCheck] = []
    for group, (name, trajectory) in zip(groups[1:], others, strict=True):
        deadline.check("certify")
        pair = [(groups[0], motion[1]), (group, trajectory)]
        # In one order, so that either motion's report is about the same proof.
        is_swapped = group.name < groups[0].name
        first, second = pair[::-1] if is_swapped else pair
        request = BesideRequest((first[0], second[0]), (first[1], second[1]), world.state, margins)
        result = check_beside(world.drake, request, deadline)
        time, other_time = result.times[::-1] if is_swapped else result.times
        a, b = result.bodies
        checks.append(
            BesideCheck(
                group=name,
                outcome=_OUTCOMES[result.outcome],
                pair=(a, b) if a in bodies[0] else (b, a),
                distance=result.distance,
                margin=result.margin,
                time=time,
                other_time=other_time,
                num_segments=result.num_segments,
            )
        )
        if not checks[-1].passed:
            break
    return BesideReport(tuple(checks))


def _validated(world: World, field: str, name: str, trajectory: TimedTrajectory) -> JointGroup:
    """Return the group of a motion, after checks of its trajectory."""
    group = world.group(name)
    # Without duration, the motion of a robot at rest.
    is_rest = not trajectory.breaks.any() and trajectory.num_pieces == 1
    one_second = replace(trajectory, breaks=np.array([0.0, 1.0])) if is_rest else trajectory
    validate_motion(group, one_second, field)
    return group


def _validate_apart(
    fields: Sequence[str], groups: Sequence[JointGroup], bodies: Sequence[frozenset[str]]
) -> None:
    """Raise if two groups move one body: its place would depend on both of their times.

    Other motions may be of one group, such as the motions in a robot's queue.
    """
    for i, j in combinations(range(len(groups)), 2):
        if i and groups[i].joints == groups[j].joints:
            continue
        shared = sorted(bodies[i] & bodies[j])
        if shared:
            message = (
                f"{fields[j]}: group {groups[j].name!r} moves body {shared[0]!r}, which "
                f"{groups[i].name!r} of {fields[i]} moves too; motions beside each other need "
                "groups that move no body in common"
            )
            raise ProblemInvalid(message, {"field": fields[j], "bodies": shared})
