"""solve_ik(): the goals stage by itself; assess_configurations(): how good its answers are."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.configuration_quality import ConfigurationQuality
from planning.domain.goals.goal import Goal
from planning.domain.goals.goal_configurations import GoalConfigurations
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import IkOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.goals.find_goals import GoalQuery, find_goals
from planning.goals.joint_metric import JointMetric
from planning.goals.quality import QualityProbe
from planning.goals.start_validation import resolve_start
from planning.pipeline.constrained_search import filter_goals
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.loading.positions import validate_positions
from planning.world.world import World


def solve_ik(  # noqa: PLR0913  (a question in full)
    world: World,
    group: str,
    goal: Goal,
    *,
    deadline: Deadline,
    start: Any = None,
    options: IkOptions | None = None,
    margin: float | None = None,
    constraints: tuple[PathConstraint, ...] = (),
    seed: int = 0,
) -> GoalConfigurations:
    """Return every distinct free configuration that reaches a goal, nearest first.

    It is what plans are made with, but that every solution that collides is measured: the funnel
    says of all of them which pair they hit.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        goal: What to reach.
        deadline: When to stop looking.
        start: The group's q to be near to, shape (nq,); None for the scene's state.
        options: How hard to look, and what is near.
        margin: Distance to keep [m]; None for the scene's.
        constraints: Path constraints, which solutions shall keep; joints are locked where the start
            has them.
        seed: Of the random seeds.

    Raises:
        GoalViolatesConstraint: Every configuration that reaches the goal does.
        GoalInCollision: Configurations reach the goal and all collide.
        GoalTooNear: They break margins, and not all collide.
        GoalUnreachable: No configuration reaches the goal.
        GoalOutOfLimits: Every given configuration violates position limits.
        UnknownName: A group, joint, frame or configuration does not exist.
        ProblemInvalid: The start does not fit the group, or an option makes no sense.
    """
    joints = world.group(group)
    q = resolve_start(world, joints, start)
    ik_options = options or IkOptions()
    path_constraints = (
        PathConstraints.compiled(world, joints, constraints, q) if constraints else None
    )
    query = GoalQuery(
        joints, goal, q, world.margins(margin), ik_options, ik_options.max_trials, path_constraints
    )
    watch = Stopwatch(deadline.clock)
    with watch.timing_failures(), watch.stage("goals"):
        goals = find_goals(world, query, np.random.default_rng(seed), deadline)
        return filter_goals(world, query, goals, seed, deadline)


def assess_configurations(
    world: World,
    group: str,
    configurations: Float64[np.ndarray, "n nq"],
    *,
    start: Any = None,
    frame: str = "",
    joint_weights: Mapping[str, float] | None = None,
) -> tuple[ConfigurationQuality, ...]:
    """Return how good each configuration of a group is.

    Args:
        world: The scene, loaded.
        group: `robot` or `robot::group`.
        configurations: The group's q [rad or m], a row each.
        start: What distances are measured from, shape (nq,); None for the scene's state.
        frame: Whose mobility counts; "" for the group's default tool frame.
        joint_weights: Factors on the joints' parts of these distances, as in `IkOptions`.

    Raises:
        UnknownName: A group, joint or frame does not exist.
        ProblemInvalid: A row or the start does not fit the group, or a weight is negative.
    """
    joints = world.group(group)
    origin = resolve_start(world, joints, start)
    tool = frame or joints.tool_frames[0]
    world.validate_frame(tool)
    metric = JointMetric.from_names(joints, joint_weights or {})
    probe = QualityProbe(world, joints, tool, metric)
    return tuple(
        probe.evaluate(validate_positions(joints, row, f"configurations.{i}"), origin)
        for i, row in enumerate(configurations)
    )
