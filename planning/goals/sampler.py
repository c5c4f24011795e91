"""Goal configurations of a goal: the stage's one entry, shared by plans and by /ik."""

import logging
from typing import Any

import numpy as np

from planning.domain.deadline import Deadline
from planning.domain.goal import ConfigurationGoal, JointGoal, LineGoal, PoseGoal
from planning.domain.joints import JointGroup
from planning.domain.manifold import Manifold
from planning.domain.report import BodyPair, Funnel, GoalConfigurations
from planning.errors import GoalInCollision, GoalOutOfLimits, ProblemInvalid
from planning.goals.goal_query import GoalQuery
from planning.goals.leg_judge import leg_judge, with_legs
from planning.goals.pose_search import PoseSearch
from planning.goals.pose_solvers import DrakePoseSolver, kernel_pose_solver
from planning.goals.ranking import Distinct, equivalents, nearest_first
from planning.goals.refusal import refusal
from planning.goals.start import (
    clip_dust,
    describe_pairs,
    limit_violations,
    pair_evidence,
    within_limits,
)
from planning.goals.tally import Tally, funnel_evidence, tallied
from planning.goals.tool_target import ToolTarget, tool_targets
from planning.world.positions import require_positions
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

_LOG = logging.getLogger(__name__)
# Where some configurations are free, so many of those that are not are measured for the report.
_LOOKED_AT = 2


def find_goals(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Return every distinct, in-limit, free goal configuration, nearest to the start first.

    Raises:
        GoalOutOfLimits: Every given configuration violates position limits.
        GoalInCollision: Configurations exist and all of them collide.
        GoalUnreachable: No configuration reaches a target pose.
        ProblemInvalid: A given configuration has the wrong count.
        UnknownName: A frame or named configuration does not exist.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Somebody asked for the end.
    """
    match query.goal:
        case LineGoal():
            message = "lines are not searched for; `trace_path` follows them"
            raise ProblemInvalid(message, {"field": "goal"})
        case PoseGoal() as goal:
            return _reaching(world, query, goal, rng, deadline)
        case ConfigurationGoal() as goal:
            rows = world.configuration(query.group, goal.name)[None]
        case JointGoal() as goal:
            rows = np.stack([
                require_positions(query.group, q, f"goal.positions.{i}")
                for i, q in enumerate(goal.positions)
            ])
    return _given(world, query, rows)


def _given(world: World, query: GoalQuery, rows: Array) -> GoalConfigurations:
    """Keep those of the given configurations that are within limits and free."""
    group, limits = query.group, world.limits(query.group)
    manifold = Manifold(group.joints)
    rows = clip_dust(limits, manifold, rows)
    inside = np.flatnonzero(within_limits(limits, rows))
    if not len(inside):
        outside = limit_violations(limits, group, rows[0])
        worst = max(outside, key=lambda entry: entry["violation"])
        message = (
            f"no goal configuration is within limits: {worst['joint']} = {worst['position']:.6g} "
            f"is not in [{worst['lower']:.6g}, {worst['upper']:.6g}]"
        )
        raise GoalOutOfLimits(message, {"joints": outside})
    is_free = world.collision_oracle(group, query.margins).are_free(rows[inside])
    tally = Tally()
    pairs: tuple[BodyPair, ...] = ()
    for k in np.flatnonzero(~is_free):
        violations = world.violations(group, rows[inside[k]], query.margins)
        is_free[k] = not violations
        pairs = pairs or violations
        tally.add(violations, query.margins)
    free = inside[is_free]
    counts = len(rows), len(rows), len(inside), len(free), len(free)
    funnel = Funnel(*counts, tally.summary, approach_ok=len(free))
    if not len(free):
        message = f"every goal configuration collides: {describe_pairs(pairs, query.margins)}"
        evidence = {"funnel": funnel_evidence(funnel), "pairs": pair_evidence(pairs, query.margins)}
        raise GoalInCollision(message, evidence)
    found, indices = nearest_first(manifold, query.start, rows[free], free, len(free))
    return GoalConfigurations(found, indices, funnel)


def _reaching(
    world: World, query: GoalQuery, goal: PoseGoal, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Sample configurations that reach a pose, by the kernel if there is one, and let Drake verify.

    Drake answers alone if it refutes a single one of the kernel's.
    """
    group = query.group
    targets = tool_targets(world, group, goal, query.start)
    state = rng.bit_generator.state
    judge = leg_judge(world, query, goal, targets, deadline)
    search: PoseSearch | None = None
    solver = kernel_pose_solver(world, group, targets)
    if solver is not None:
        search = PoseSearch(world, query, len(targets), solver, rng, deadline, judge)
        search.run()
        if not _are_met(world, group, targets, search.found):
            _LOG.error("Drake refutes the kernel's inverse kinematics of %s", targets[0].frame)
            rng.bit_generator.state, search = state, None
    if search is None:
        judge = leg_judge(world, query, goal, targets, deadline)
        drake = DrakePoseSolver(world, group, targets, deadline)
        search = PoseSearch(world, query, len(targets), drake, rng, deadline, judge)
        search.run()
    if not len(search.found):
        deadline.check("goals")
        raise refusal(world, query, targets, search, rng)
    funnel = search.funnel(tallied(world, query, search.colliding[:_LOOKED_AT]).summary)
    limits = world.limits(group)
    rows, index = equivalents(group, limits, search.found.rows)
    turned = search.found.targets[index]
    count = query.options.max_configurations
    if judge is not None:
        legs = judge.legs_of(search.found.rows[index], rows)
        return with_legs(query, limits, (rows, turned, legs), funnel)
    nearest = nearest_first(Manifold(group.joints), query.start, rows, turned, count)
    return GoalConfigurations(*nearest, funnel)


def _are_met(world: World, group: JointGroup, targets: list[ToolTarget], found: Distinct) -> bool:
    """Return whether Drake agrees that every solution reaches its target."""
    reached = world.frame_poses(targets[0].frame, world.embed(group, found.rows))
    return all(
        bool(target.are_met_by(reached[found.targets == i]).all())
        for i, target in enumerate(targets)
    )
