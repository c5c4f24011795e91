"""Poses, goals and problems: from the wire to the domain."""

from typing import Any

import numpy as np

from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import (
    ConfigurationGoal,
    Goal,
    JointGoal,
    LineGoal,
    PoseBall,
    PoseGoal,
    PoseTarget,
    ReachGoal,
    RegionGoal,
    RelativeGoal,
)
from planning.domain.goals.linear_moves import Displacement
from planning.domain.request.options import (
    CertifyOptions,
    ClearanceObjective,
    IkOptions,
    PoseMetric,
    RefineOptions,
    RetimeOptions,
    RoadmapOptions,
    SearchOptions,
)
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.steering import Steering
from service.api.pose import PoseWire
from service.plans.models.constraint_values import constraint_values
from service.plans.models.goals import (
    ConfigurationGoalWire,
    GoalWire,
    JointGoalWire,
    PoseBallWire,
    PoseGoalWire,
    RegionGoalWire,
    RelativeGoalWire,
)
from service.plans.models.ik import IkWire
from service.plans.models.line_goals import LineEndWire, LineGoalWire, PathGoalWire, WayWire
from service.plans.models.motion_limit_values import motion_limits
from service.plans.models.request import CertifyWire, PlanRequest, RefineWire, RetimeWire
from service.plans.models.search import CarWire, RoadmapWire, SearchWire


def pose_value(pose: PoseWire) -> Pose:
    """Return the domain's pose, without its frame."""
    return Pose.from_parts(pose.position, pose.quaternion, pose.rpy)


def pose_wire(pose: Pose) -> dict[str, object]:
    """Return a pose in world for the wire."""
    return {
        "position": pose.position.tolist(),
        "quaternion": pose.quaternion.tolist(),
        "frame": "world",
    }


def target_value(pose: PoseWire) -> PoseTarget:
    """Return the domain's pose with the frame that it is given in."""
    return PoseTarget(pose_value(pose), pose.frame)


def pose_goal_value(goal: PoseGoalWire) -> PoseGoal:
    """Return the domain's pose goal."""
    return PoseGoal(
        targets=tuple(map(target_value, goal.poses)),
        frame=goal.frame or "",
        position_tolerance=np.array(goal.tolerance.position, dtype=np.float64),
        rotation_tolerance=np.array(goal.tolerance.rotation, dtype=np.float64),
        approach=_way(goal.approach),
        retreat=_way(goal.retreat),
        ball=None if goal.metric is None else _ball(goal.metric),
    )


def _ball(metric: PoseBallWire) -> PoseBall:
    weights = np.array(metric.weights, dtype=np.float64)
    return PoseBall(metric.tolerance, weights, metric.frame or "")


def line_end_value(end: LineEndWire) -> PoseTarget | Displacement:
    """Return where a line shall lead."""
    if end.pose is not None:
        return target_value(end.pose)
    way = end.displacement or WayWire(vector=[0.0, 0.0, 0.0])
    return Displacement(np.array(way.vector, dtype=np.float64), way.frame)


def line_goal_value(goal: LineGoalWire | PathGoalWire) -> LineGoal:
    """Return the domain's goal of one line or several."""
    ends = (
        (line_end_value(goal),)
        if isinstance(goal, LineGoalWire)
        else tuple(map(target_value, goal.poses))
    )
    return LineGoal(ends, goal.frame or "", goal.deviation.position, goal.deviation.rotation)


def _way(vector: list[float] | None) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    return None if vector is None else np.array(vector, dtype=np.float64)


def region_goal_value(goal: RegionGoalWire) -> RegionGoal:
    """Return the domain's region goal; what is free has no bound."""
    poses = goal.poses if goal.pose is None else [goal.pose]
    position = np.array(goal.tolerance.position, dtype=np.float64)
    turn = np.array(goal.tolerance.rotation, dtype=np.float64)
    position[[axis in goal.free_axes for axis in ("x", "y", "z")]] = np.inf
    turn[[axis in goal.free_axes for axis in ("rx", "ry", "rz")]] = np.pi
    return RegionGoal(
        targets=tuple(map(target_value, poses or ())),
        frame=goal.frame or "",
        position_tolerance=position,
        rotation_tolerance=turn,
        approach=_way(goal.approach),
        retreat=_way(goal.retreat),
    )


def reach_goal_value(goal: PoseGoalWire | RegionGoalWire | RelativeGoalWire) -> ReachGoal:
    """Return the domain's goal of a tool frame."""
    match goal:
        case PoseGoalWire():
            return pose_goal_value(goal)
        case RegionGoalWire():
            return region_goal_value(goal)
        case RelativeGoalWire():
            by = goal.displacement
            moved = Pose.from_parts(by.position or (0.0, 0.0, 0.0), by.quaternion, by.rpy)
            return RelativeGoal(moved, goal.frame or "", goal.reference or "")


def goal_value(goal: GoalWire) -> Goal:
    """Return the domain's goal."""
    match goal:
        case JointGoalWire():
            return JointGoal(np.atleast_2d(np.array(goal.positions, dtype=np.float64)))
        case ConfigurationGoalWire():
            return ConfigurationGoal(goal.name)
        case LineGoalWire() | PathGoalWire():
            return line_goal_value(goal)
        case _:
            return reach_goal_value(goal)


def ik_value(ik: IkWire) -> IkOptions:
    """Return the domain's IK options."""
    metric = PoseMetric(ik.pose_metric.translation, ik.pose_metric.rotation)
    weights = dict(ik.joint_weights)
    return IkOptions(ik.max_configurations, ik.max_trials, weights, metric, ik.time_limit)


def retime_value(retime: RetimeWire) -> RetimeOptions:
    """Return the domain's options of the timing."""
    return RetimeOptions(
        method=retime.method,
        sample_period=retime.sampling.period,
        duration=retime.duration,
        deviation=retime.deviation,
        explain=retime.explain,
        **motion_limits(retime),
    )


def roadmap_value(roadmap: RoadmapWire) -> RoadmapOptions:
    """Return the domain's options of a roadmap."""
    return RoadmapOptions(roadmap.states, roadmap.neighbours, roadmap.seed)


def certify_value(certify: CertifyWire) -> CertifyOptions:
    """Return the domain's options of the proof."""
    return CertifyOptions(certify.stop_anywhere, certify.max_stopping_time, certify.robustness)


def steering_value(car: CarWire) -> Steering:
    """Return how the domain says that a base is steered."""
    return Steering(car.turning_radius, car.reverse)


def search_value(search: SearchWire) -> SearchOptions:
    """Return the domain's search options."""
    return SearchOptions(
        planner=search.planner if isinstance(search.planner, str) else tuple(search.planner),
        parameters=dict(search.parameters),
        attempts=search.attempts,
        allowed_planning_time=search.allowed_planning_time,
        resolution=search.resolution,
        num_states=search.num_states,
        approach_states=search.approach_states,
        weights=dict(search.weights),
        bounds={name: (low, high) for name, (low, high) in search.bounds.items()},
        spaces={
            name: steering_value(space) if isinstance(space, CarWire) else space
            for name, space in search.spaces.items()
        },
        setup_time=search.setup_time,
        solve_time=search.solve_time,
        shortcut_time=search.shortcut_time,
        interpolate_time=search.interpolate_time,
        objective=search.objective,
        approximate=search.approximate,
        keep_graph=search.keep_graph,
        on_cancel=search.on_cancel,
        roadmap=None if search.roadmap is None else roadmap_value(search.roadmap),
    )


def _refine(wire: RefineWire) -> RefineOptions:
    wish = wire.clearance
    return RefineOptions(wire.method, wish and ClearanceObjective(wish.distance, wish.weight))


def problem_value(request: PlanRequest) -> PlanningProblem:
    """Return the domain's problem; every field of the request is in it but for the scene."""
    return PlanningProblem(
        group=request.group,
        goal=goal_value(request.goal),
        start=None if request.start is None else np.array(request.start, dtype=np.float64),
        ik=ik_value(request.ik),
        search=search_value(request.search),
        refine=_refine(request.refine),
        retime=retime_value(request.retime),
        margin=request.margin,
        seed=request.seed,
        constraints=constraint_values(request.path_constraints),
        certify=certify_value(request.certify),
    )
