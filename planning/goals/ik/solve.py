"""IK search for a tool goal: by the native kernel, verified by Drake, or else by Drake alone."""

import logging
from collections.abc import Callable
from functools import partial

import numpy as np

from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_search import PoseSearch
from planning.goals.ik.pose_solvers import (
    DrakePoseSolver,
    PoseSolver,
    exact_kernel_solver,
    kernel_pose_solver,
)
from planning.goals.lines.approach import approach_checker
from planning.goals.ranking import UniqueSolutions
from planning.goals.targets.target_samples import ExactPoses, TargetSamples
from planning.goals.targets.target_selection import TargetSelection, select_targets
from planning.world.world import World

_LOG = logging.getLogger(__name__)


def solve_tool_goal(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> tuple[TargetSelection, PoseSearch]:
    """Search configurations of a tool goal by the kernel, if available, and verify them by Drake.

    If Drake's forward kinematics refutes a single solution of the kernel, all are discarded and
    the search is repeated by Drake alone.

    Returns:
        The target selection of the goal, and the finished search with its solutions.
    """
    group = query.group
    aiming = select_targets(world, query, rng)
    state = rng.bit_generator.state
    kernel = partial(_by_kernel, world, group)
    search = _followed(world, query, aiming, kernel, rng, deadline)
    if search is not None and not _are_met(world, group, aiming, search.found):
        _LOG.error("Drake refutes the kernel's inverse kinematics of %s", group.name)
        search = None
    if search is None:
        rng.bit_generator.state = state
        drake = partial(_by_drake, world, group, deadline)
        search = _followed(world, query, aiming, drake, rng, deadline)
    assert search is not None  # noqa: S101  (Drake always has a solver)
    return aiming, search


def _followed(
    world: World,
    query: GoalQuery,
    aiming: TargetSelection,
    solver_of: Callable[[TargetSamples], PoseSolver | None],
    rng: np.random.Generator,
    deadline: Deadline,
) -> PoseSearch | None:
    """Return the finished search over a target selection; None if `solver_of` has no solver."""
    trials = query.options.max_trials
    first = int(np.ceil(aiming.share * trials))
    judge = approach_checker(world, query, aiming.accepted, deadline)
    search = PoseSearch(world, query, rng, deadline, judge)
    for aims in aiming.first:
        solver = solver_of(aims)
        if solver is None:
            return None
        search.run(aims, solver, first)
        if aiming.then is not None and not len(search.found) and search.is_done(first):
            search.run(aiming.then, solver_of(aiming.then) or solver, trials)
        search.run(aims, solver, trials)
        if search.is_done(trials):
            break
    return search


def _by_kernel(world: World, group: JointGroup, aims: TargetSamples) -> PoseSolver | None:
    targets = aims.targets
    if isinstance(targets, ExactPoses):
        poses = targets.positions, targets.quaternions
        return exact_kernel_solver(world, group, targets.frame, poses)
    return kernel_pose_solver(world, group, targets)


def _by_drake(
    world: World, group: JointGroup, deadline: Deadline, aims: TargetSamples
) -> PoseSolver:
    targets = aims.targets
    each = targets.each if isinstance(targets, ExactPoses) else targets
    return DrakePoseSolver(world, group, deadline, each)


def _are_met(
    world: World, group: JointGroup, aiming: TargetSelection, found: UniqueSolutions
) -> bool:
    """Return whether every solution reaches its target by Drake's forward kinematics."""
    frame = aiming.accepted[0].frame
    reached = world.frame_poses(frame, world.embed(group, found.rows))
    return all(
        bool(target.are_met_by(reached[found.targets == i]).all())
        for i, target in enumerate(aiming.accepted)
    )
