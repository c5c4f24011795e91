"""solve_ik(): inverse kinematics of a goal; assess_configurations(): quality of configurations."""

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


def solve_ik(  # noqa: PLR0913  (all inputs of a request)
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
    """Return the distinct free configurations that reach a goal, nearest to the start first.

    This is the goals stage of a plan, except that all colliding solutions are measured: the funnel
    counts the colliding body pairs of all of them.

    Args:
        world: Loaded scene.
        group: `robot` or `robot::group`.
        goal: Goal to reach.
        deadline: Time limit.
        start: The group's q that distances are measured from, shape (nq,); None for the scene's
            state.
        options: Effort of the search and metric of distances; None for the defaults.
        margin: Required distance of bodies [m]; None for the scene's.
        constraints: Path constraints that solutions satisfy; joints are locked at their values in
            `start`.
        seed: Seed of all random numbers.

    Raises:
        GoalViolatesConstraint: Every configuration that reaches the goal violates a constraint.
        GoalInCollision: Configurations reach the goal and all collide.
        GoalTooNear: Configurations reach the goal, all violate margins, and not all collide.
        GoalUnreachable: No configuration reaches the goal.
        GoalOutOfLimits: Every given configuration violates position limits.
        ApproachBlocked: No free configuration has a free approach and retreat.
        UnknownName: A group, joint, frame or configuration does not exist.
        ProblemInvalid: The start does not fit the group, or an option is invalid.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Cancellation was requested.
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
    """Return the quality of each configuration: manipulability, clearance, limit margin, branch.

    Args:
        world: Loaded scene.
        group: `robot` or `robot::group`.
        configurations: The group's q [rad or m], one per row.
        start: Configuration that distances are measured from, shape (nq,); None for the scene's
            state.
        frame: Frame whose manipulability is evaluated; "" for the group's default tool frame.
        joint_weights: Weights of the joints in these distances, as in `IkOptions`.

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
