"""IK search for a tool goal: by the native kernel, verified by Drake, or else by Drake alone."""

import logging
from collections.abc import Callable
from dataclasses import replace
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
from planning.goals.lines.approach_checker import approach_checker
from planning.goals.ranking import UniqueSolutions
from planning.goals.targets.target_samples import ExactPoses, TargetSamples
from planning.goals.targets.target_selection import TargetSelection, select_targets
from planning.world.mechanics.idle_joints import idle_positions
from planning.world.world import World

_LOG = logging.getLogger(__name__)
# Share of the time for a goal at which the group's other joints stay where they are.
_KEPT_TIME_FRACTION = 0.5


def solve_tool_goal(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> tuple[TargetSelection, PoseSearch]:
    """Search for configurations of a tool goal by the kernel, if available; verify them by Drake.

    Joints that do not move the tool, such as those of a group's other arm, stay where the start has
    them; only if nothing is found so, they are free.

    Returns:
        The target selection of the goal, and the finished search with its solutions.
    """
    selection = select_targets(world, query, rng)
    kept = idle_positions(world.drake, query.group, selection.accepted[0].frame)
    if kept.any():
        own_deadline = deadline.at_fraction(_KEPT_TIME_FRACTION)
        search = _verified_search(world, replace(query, kept=kept), selection, rng, own_deadline)
        if len(search.solutions):
            return selection, search
    return selection, _verified_search(world, query, selection, rng, deadline)


def _verified_search(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    rng: np.random.Generator,
    deadline: Deadline,
) -> PoseSearch:
    """Return the finished search over a target selection.

    If Drake's forward kinematics refutes a single solution of the kernel, all are discarded and
    the search is repeated by Drake alone.
    """
    group = query.group
    state = rng.bit_generator.state
    make_kernel_solver = partial(_kernel_solver, world, group)
    search = _run_search(world, query, selection, make_kernel_solver, rng, deadline)
    if search is not None and not _are_confirmed_by_drake(
        world, group, selection, search.solutions
    ):
        _LOG.error("Drake refutes the kernel's inverse kinematics of %s", group.name)
        search = None
    if search is None:
        rng.bit_generator.state = state
        make_drake_solver = partial(_drake_solver, world, group, deadline)
        search = _run_search(world, query, selection, make_drake_solver, rng, deadline)
    assert search is not None  # noqa: S101  (Drake always has a solver)
    return search


def _run_search(
    world: World,
    query: GoalQuery,
    selection: TargetSelection,
    make_solver: Callable[[TargetSamples], PoseSolver | None],
    rng: np.random.Generator,
    deadline: Deadline,
) -> PoseSearch | None:
    """Return the finished search over a target selection; None if `make_solver` has no solver."""
    max_trials = query.options.max_trials
    num_first_trials = int(np.ceil(selection.first_phase_fraction * max_trials))
    checker = approach_checker(world, query, selection.accepted, deadline)
    search = PoseSearch(world, query, rng, deadline, checker)
    for samples in selection.first_phase:
        solver = make_solver(samples)
        if solver is None:
            return None
        search.run(samples, solver, num_first_trials)
        if (
            selection.fallback is not None
            and not len(search.solutions)
            and search.is_done(num_first_trials)
        ):
            search.run(selection.fallback, make_solver(selection.fallback) or solver, max_trials)
        search.run(samples, solver, max_trials)
        if search.is_done(max_trials):
            break
    return search


def _kernel_solver(world: World, group: JointGroup, samples: TargetSamples) -> PoseSolver | None:
    targets = samples.targets
    if isinstance(targets, ExactPoses):
        poses = targets.positions, targets.quaternions
        return exact_kernel_solver(world, group, targets.frame, poses)
    return kernel_pose_solver(world, group, targets)


def _drake_solver(
    world: World, group: JointGroup, deadline: Deadline, samples: TargetSamples
) -> PoseSolver:
    targets = samples.targets
    each = targets.tool_targets if isinstance(targets, ExactPoses) else targets
    return DrakePoseSolver(world, group, deadline, each)


def _are_confirmed_by_drake(
    world: World, group: JointGroup, selection: TargetSelection, solutions: UniqueSolutions
) -> bool:
    """Return whether every solution reaches its target by Drake's forward kinematics."""
    frame = selection.accepted[0].frame
    tool_poses = world.frame_poses(frame, world.embed(group, solutions.rows))
    return all(
        bool(target.are_met_by(tool_poses[solutions.targets == i]).all())
        for i, target in enumerate(selection.accepted)
    )
