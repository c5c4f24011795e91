"""Poses, goals and problems: from the wire to the domain."""

from typing import Any

import numpy as np

from planning.domain.geometry import pose as geometry
from planning.domain.goals import goal as domain
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
from service.api.pose import Pose
from service.plans.models.constraint_values import constraint_values
from service.plans.models.goals import (
    ConfigurationGoal,
    Goal,
    JointGoal,
    PoseBall,
    PoseGoal,
    RegionGoal,
    RelativeGoal,
)
from service.plans.models.ik import Ik
from service.plans.models.line_goals import LineEnd, LineGoal, PathGoal, Way
from service.plans.models.motion_limit_values import motion_limits
from service.plans.models.request import Certify, PlanRequest, Refine, Retime
from service.plans.models.search import Car, Roadmap, Search


def pose_value(pose: Pose) -> geometry.Pose:
    """Return the domain's pose, without its frame."""
    return geometry.Pose.from_parts(pose.position, pose.quaternion, pose.rpy)


def pose_of(pose: geometry.Pose) -> Pose:
    """Return the model of a pose in world, which is not validated again."""
    position, quaternion = pose.position.tolist(), pose.quaternion.tolist()
    return Pose.model_construct(position=position, quaternion=quaternion)


def pose_wire(pose: geometry.Pose) -> dict[str, object]:
    """Return a pose in world for the wire."""
    return {
        "position": pose.position.tolist(),
        "quaternion": pose.quaternion.tolist(),
        "frame": "world",
    }


def target_value(pose: Pose) -> domain.PoseTarget:
    """Return the domain's pose with the frame that it is given in."""
    return domain.PoseTarget(pose_value(pose), pose.frame)


def pose_goal_value(goal: PoseGoal) -> domain.PoseGoal:
    """Return the domain's pose goal."""
    return domain.PoseGoal(
        targets=tuple(map(target_value, goal.poses)),
        frame=goal.frame or "",
        position_tolerance=np.array(goal.tolerance.position, dtype=np.float64),
        rotation_tolerance=np.array(goal.tolerance.rotation, dtype=np.float64),
        approach=_way(goal.approach),
        retreat=_way(goal.retreat),
        ball=None if goal.metric is None else _ball(goal.metric),
    )


def _ball(metric: PoseBall) -> domain.PoseBall:
    weights = np.array(metric.weights, dtype=np.float64)
    return domain.PoseBall(metric.tolerance, weights, metric.frame or "")


def line_end_value(end: LineEnd) -> domain.PoseTarget | Displacement:
    """Return where a line shall lead."""
    if end.pose is not None:
        return target_value(end.pose)
    way = end.displacement or Way(vector=[0.0, 0.0, 0.0])
    return Displacement(np.array(way.vector, dtype=np.float64), way.frame)


def line_goal_value(goal: LineGoal | PathGoal) -> domain.LineGoal:
    """Return the domain's goal of one line or several."""
    ends = (
        (line_end_value(goal),)
        if isinstance(goal, LineGoal)
        else tuple(map(target_value, goal.poses))
    )
    return domain.LineGoal(ends, goal.frame or "", goal.deviation.position, goal.deviation.rotation)


def _way(vector: list[float] | None) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    return None if vector is None else np.array(vector, dtype=np.float64)


def region_goal_value(goal: RegionGoal) -> domain.RegionGoal:
    """Return the domain's region goal; what is free has no bound."""
    poses = goal.poses if goal.pose is None else [goal.pose]
    position = np.array(goal.tolerance.position, dtype=np.float64)
    turn = np.array(goal.tolerance.rotation, dtype=np.float64)
    position[[axis in goal.free_axes for axis in ("x", "y", "z")]] = np.inf
    turn[[axis in goal.free_axes for axis in ("rx", "ry", "rz")]] = np.pi
    return domain.RegionGoal(
        targets=tuple(map(target_value, poses or ())),
        frame=goal.frame or "",
        position_tolerance=position,
        rotation_tolerance=turn,
        approach=_way(goal.approach),
        retreat=_way(goal.retreat),
    )


def reach_goal_value(goal: PoseGoal | RegionGoal | RelativeGoal) -> domain.ReachGoal:
    """Return the domain's goal of a tool frame."""
    match goal:
        case PoseGoal():
            return pose_goal_value(goal)
        case RegionGoal():
            return region_goal_value(goal)
        case RelativeGoal():
            by = goal.displacement
            moved = geometry.Pose.from_parts(by.position or (0.0, 0.0, 0.0), by.quaternion, by.rpy)
            return domain.RelativeGoal(moved, goal.frame or "", goal.reference or "")


def goal_value(goal: Goal) -> domain.Goal:
    """Return the domain's goal."""
    match goal:
        case JointGoal():
            return domain.JointGoal(np.atleast_2d(np.array(goal.positions, dtype=np.float64)))
        case ConfigurationGoal():
            return domain.ConfigurationGoal(goal.name)
        case LineGoal() | PathGoal():
            return line_goal_value(goal)
        case _:
            return reach_goal_value(goal)


def ik_value(ik: Ik) -> IkOptions:
    """Return the domain's IK options."""
    metric = PoseMetric(ik.pose_metric.translation, ik.pose_metric.rotation)
    weights = dict(ik.joint_weights)
    return IkOptions(ik.max_configurations, ik.max_trials, weights, metric, ik.time_limit)


def retime_value(retime: Retime) -> RetimeOptions:
    """Return the domain's options of the timing."""
    return RetimeOptions(
        method=retime.method,
        sample_period=retime.sampling.period,
        duration=retime.duration,
        deviation=retime.deviation,
        explain=retime.explain,
        **motion_limits(retime),
    )


def roadmap_value(roadmap: Roadmap) -> RoadmapOptions:
    """Return the domain's options of a roadmap."""
    return RoadmapOptions(roadmap.states, roadmap.neighbours, roadmap.seed)


def certify_value(certify: Certify) -> CertifyOptions:
    """Return the domain's options of the proof."""
    return CertifyOptions(certify.stop_anywhere, certify.max_stopping_time, certify.robustness)


def steering_value(car: Car) -> Steering:
    """Return how the domain says that a base is steered."""
    return Steering(car.turning_radius, car.reverse)


def search_value(search: Search) -> SearchOptions:
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
            name: steering_value(space) if isinstance(space, Car) else space
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


def _refine(wire: Refine) -> RefineOptions:
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
