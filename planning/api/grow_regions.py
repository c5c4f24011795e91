"""grow_regions(): convex regions of a group's free configurations, for the planner "GCS"."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from planning.api.ik import solve_ik
from planning.domain.arrays import Array
from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import PoseGoal, PoseTarget
from planning.domain.planner.regions import RegionOptions, Regions
from planning.domain.report.motion_plan import Progress, ignore_progress
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import IkOptions, SearchOptions
from planning.domain.request.region_request import validate_convex, validate_one_turn
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.errors import (
    DeadlineExceeded,
    GoalInCollision,
    GoalOutOfLimits,
    GoalTooNear,
    GoalUnreachable,
    NoPathFound,
    ProblemInvalid,
    UnknownName,
)
from planning.regions.grow import GrowRequest, Growth, grow
from planning.search.request import SearchTask
from planning.search.solver import search
from planning.world.world import CollisionChecker, World

# Largest distance between the samples of a path, each of which seeds a region unless one contains
# it already [rad or m].
_MAX_STEP = 0.1
# Share of the remaining time for the search of one path.
_PATH_TIME_FRACTION = 0.1
# Failures for which a frame of the scene is skipped.
_GOAL_FAILURES = (GoalInCollision, GoalTooNear, GoalUnreachable, GoalOutOfLimits, DeadlineExceeded)


def grow_regions(
    world: World,
    group: str,
    *,
    deadline: Deadline,
    options: RegionOptions | None = None,
    seed: int = 0,
    on_progress: Callable[[Progress], None] = ignore_progress,
) -> Regions:
    """Grow convex regions of free configurations; at the deadline, return those so far.

    The same arguments give the same bytes, unless the deadline ends the growth. A region is free as
    far as random samples show (see `Region`); motions planned inside are certified like all others.

    Args:
        world: Loaded scene.
        group: `robot` or `robot::group`.
        deadline: Time limit, and whether the growth was canceled.
        options: Number, coverage and bounds of the regions; None for the defaults.
        seed: Seed of all random numbers.
        on_progress: Callback for the progress, with every region.

    Raises:
        UnknownName: There is no such group, or it has no such position coordinate.
        ProblemInvalid: The group has a floating or steered joint, or an unbounded coordinate, or an
            option is invalid.
        Canceled: Cancellation was requested.
    """
    joints, region_options = world.group(group), options or RegionOptions()
    _validate_options(region_options)
    lower, upper = domain_of(world, joints, region_options)
    margins = world.margins(region_options.margin, region_options.padding)
    checker = world.collision_oracle(joints, margins)
    limits = replace(world.limits(joints), lower=lower, upper=upper)
    on_progress(Progress("regions", 0.0, "looking for paths"))
    paths = (
        []
        if region_options.along == "nothing"
        else list(_paths(world, joints, limits, checker, deadline))
    )
    request = GrowRequest(checker, lower, upper, paths, region_options, seed)

    def report_growth(growth: Growth) -> None:
        count = len(growth.regions)
        fraction = max(
            count / region_options.num_regions, growth.coverage / region_options.coverage
        )
        detail = f"{count} regions cover {growth.coverage:.1%} of the free space"
        on_progress(Progress("regions", min(0.99, 0.05 + 0.94 * fraction), detail))

    growth = grow(request, deadline, report_growth)
    return Regions(
        scene=world.digest,
        group=joints.name,
        margin=world.margins(region_options.margin).default,
        seed=seed,
        lower=lower,
        upper=upper,
        regions=tuple(growth.regions),
        portals=tuple(growth.portals),
        coverage=growth.coverage,
        coverage_error=growth.coverage_error,
        stopped_by=growth.stopped_by,
    )


def domain_of(world: World, group: JointGroup, options: RegionOptions) -> tuple[Array, Array]:
    """Return the box of configurations in which regions are grown: lower and upper corner, (nq,).

    It is the intersection of the limits and the options' bounds. Angles with a wider range are
    restricted to one turn around 0: that contains all postures, and all motions that do not cross
    half a turn. Angles in `group.winding` keep their whole range, since a full turn moves their
    followers elsewhere.

    Raises:
        ProblemInvalid: The group has a floating or steered joint, a coordinate is unbounded, or the
            bounds of an angle are wider than a turn.
        UnknownName: The bounds name a coordinate that the group does not have.
    """
    kinds = {joint.name: joint.type for joint in group.joints}
    validate_convex(kinds, steering_of(group), "group")
    validate_one_turn(group.joints, options.bounds)
    limits = world.limits(group)
    lower, upper = np.array(limits.lower), np.array(limits.upper)
    is_angle = np.array([
        _is_angle(joint.type, k) and joint.name not in group.winding
        for joint in group.joints
        for k in range(joint.num_positions)
    ])
    is_wide = is_angle & (upper - lower > 2 * np.pi)
    lower, upper = np.where(is_wide, -np.pi, lower), np.where(is_wide, np.pi, upper)
    for name, (low, high) in options.bounds.items():
        if name not in group.position_names:
            raise UnknownName.among("position", name, group.position_names)
        k = group.position_names.index(name)
        lower[k], upper[k] = max(low, limits.lower[k]), min(high, limits.upper[k])
    for k, name in enumerate(group.position_names):
        if not (np.isfinite([lower[k], upper[k]]).all() and lower[k] < upper[k]):
            raise _unbounded_coordinate(
                name, options, float(limits.lower[k]), float(limits.upper[k])
            )
    return lower, upper


def _unbounded_coordinate(
    name: str, options: RegionOptions, low: float, high: float
) -> ProblemInvalid:
    """Return the error of a coordinate without a finite interval of its limits and bounds."""
    evidence: dict[str, Any] = {"field": f"bounds.{name}"}
    limits = f"limits [{low:g}, {high:g}]"
    given = options.bounds.get(name)
    if given is None:
        message = (
            f"regions need a finite interval of {name}, whose {limits} are none: "
            f"give `bounds.{name}`"
        )
    else:
        evidence["bounds"] = list(given)
        message = (
            f"regions need a finite interval of {name}: its bounds [{given[0]:g}, {given[1]:g}] "
            f"and its {limits} have none in common"
        )
    return ProblemInvalid(message, evidence)


def _is_angle(kind: JointType, coordinate: int) -> bool:
    """Return whether a position coordinate is an angle."""
    is_yaw = kind is JointType.PLANAR and coordinate == 2
    return is_yaw or kind in {JointType.REVOLUTE, JointType.CONTINUOUS}


def _validate_options(options: RegionOptions) -> None:
    requirements = {
        "num_regions": (options.num_regions >= 1, "at least 1"),
        "coverage": (0 < options.coverage <= 1, "greater than 0 and at most 1"),
        "num_free": (options.num_free >= 1, "at least 1"),
        "iterations": (options.iterations >= 1, "at least 1"),
        "padding": (options.padding >= 0, "a distance of at least 0 m"),
        "margin": (options.margin is None or options.margin >= 0, "a distance of at least 0 m"),
    }
    for field, (is_met, requirement) in requirements.items():
        if not is_met:
            message = (
                f"{field} of the regions is {getattr(options, field)}; it must be {requirement}"
            )
            raise ProblemInvalid(message, {"field": field})


def _paths(
    world: World,
    group: JointGroup,
    limits: JointLimits,
    checker: CollisionChecker,
    deadline: Deadline,
) -> Iterator[Array]:
    """Yield samples of paths from the first configuration of the scene to its others, (n, nq).

    The first one is the scene's state, if it is free and within limits. A configuration to which no
    path is found is yielded by itself.
    """
    configurations = [
        q for q in _scene_configurations(world, group, deadline) if checker.is_free(q)
    ]
    inside = [q for q in configurations if ((limits.lower <= q) & (q <= limits.upper)).all()]
    manifold = Manifold(group.joints)
    for q in inside[1:]:
        task = SearchTask(inside[0], q[None], SearchOptions(), 0.05, 0.0, 0)
        try:
            path = search(
                group, limits, checker, task, deadline.at_fraction(_PATH_TIME_FRACTION)
            ).path
        except (NoPathFound, DeadlineExceeded):
            yield q[None]
            continue
        samples = _sample_path(path.continuous, manifold)
        yield samples[((limits.lower <= samples) & (samples <= limits.upper)).all(axis=1)]
    if len(inside) == 1:
        yield inside[0][None]


def _scene_configurations(world: World, group: JointGroup, deadline: Deadline) -> Iterator[Array]:
    """Yield the scene's state, the named configurations, and one at each of the scene's frames."""
    yield np.array(world.positions(group))
    yield from (np.array(q) for q in world.configurations(group).values())
    if not group.tool_frames:
        return
    exact = np.zeros(3)
    for frame in world.scene.frames:
        goal = PoseGoal((PoseTarget(Pose.identity(), frame.name),), "", exact, exact)
        try:
            solutions = solve_ik(
                world,
                group.name,
                goal,
                deadline=deadline.at_fraction(_PATH_TIME_FRACTION),
                options=IkOptions(max_configurations=8),
            )
        except _GOAL_FAILURES:
            continue
        yield np.array(solutions.positions[0])


def _sample_path(path: JointPath, manifold: Manifold) -> Array:
    """Return samples along a path at most `_MAX_STEP` apart, both ends included."""
    rows = [path.waypoints[:1]]
    for q0, q1 in pairwise(path.waypoints):
        count = max(1, int(np.ceil(float(manifold.distance(q1, q0)) / _MAX_STEP)))
        rows.append(manifold.interpolate(q0, q1, np.arange(1, count + 1) / count))
    return np.concatenate(rows)
