"""Motion planning that proves what it plans: load a world, plan, check, solve IK, execute.

These names are the doors; what lies behind them may move. Drake, OMPL, toppra and ruckig are
imported when a door that needs them is first opened, so that `import planning` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planning.api.certify_trajectory import certify_positions, certify_trajectory
    from planning.api.grow_regions import grow_regions
    from planning.api.ik import assess_configurations, solve_ik
    from planning.api.line import TraceResolution, trace_line
    from planning.api.motion_series import MotionSeries, motion_series
    from planning.api.planners import list_planners
    from planning.api.retime_path import RetimedPath, retime_path
    from planning.api.reverse_plan import reverse_plan
    from planning.api.sample_motion import (
        sample_motion,
        sample_plan,
        unproven_samples,
    )
    from planning.api.splice_motion import ProvenMotion, splice_motion, stop_motion
    from planning.domain.curves.curve import TimedTrajectory
    from planning.domain.curves.interpolation import polyline_through, trajectory_through
    from planning.domain.curves.sampling import Sampling
    from planning.domain.geometry.pose import Pose
    from planning.domain.goals.configuration_quality import ConfigurationQuality
    from planning.domain.goals.funnel import funnel_evidence, funnel_summary
    from planning.domain.goals.goal import (
        ConfigurationGoal,
        GoalPredicate,
        JointGoal,
        LineGoal,
        PoseBall,
        PoseGoal,
        PoseTarget,
        RegionGoal,
        RelativeGoal,
    )
    from planning.domain.goals.line_trace import LineTrace
    from planning.domain.goals.linear_moves import Displacement
    from planning.domain.planner.planner_card import PlannerCard
    from planning.domain.planner.regions import RegionOptions, Regions
    from planning.domain.planner.roadmap import Roadmap
    from planning.domain.report.motion_plan import MotionPlan, Progress
    from planning.domain.request.attempt_pool import AttemptPool
    from planning.domain.request.constraint import (
        DistanceBand,
        KeepIn,
        KeepOut,
        LockedJoints,
        OrientationCone,
        PathPredicate,
        PlacedBox,
        PositionBand,
        TightLimits,
    )
    from planning.domain.request.deadline import Deadline
    from planning.domain.request.motion_limits import SpeedZone, ToolLimit
    from planning.domain.request.options import (
        CertifyOptions,
        ClearanceWish,
        IkOptions,
        PoseMetric,
        RefineOptions,
        RetimeOptions,
        RoadmapOptions,
        SearchOptions,
    )
    from planning.domain.request.problem import PlanningProblem
    from planning.domain.robot.payload import Payload
    from planning.domain.robot.steering import Steering
    from planning.domain.scene.kept_files import KeptFiles
    from planning.domain.scene.scene import Scene
    from planning.domain.scene.scene_operation import (
        AddObject,
        AllowPair,
        AttachObject,
        DetachObject,
        ForbidPair,
        MoveObject,
        RemoveObject,
        SetPositions,
    )
    from planning.kernel.native import kernel_name
    from planning.parallel.core_leases import CoreLeases
    from planning.parallel.fork_pool import ForkPool
    from planning.pipeline.plan import plan
    from planning.roadmaps.load_or_build import build_roadmap
    from planning.roadmaps.roadmap_cache import RoadmapCache, RoadmapStore
    from planning.world.check import check_configurations
    from planning.world.documents.scene_document import SceneDocument
    from planning.world.documents.scene_edit import edit_scene
    from planning.world.documents.scene_file import parse_scene, read_scene, with_line
    from planning.world.documents.scene_writer import scene_document
    from planning.world.loading.load_world import load_world
    from planning.world.mechanics.kinematics import forward_kinematics
    from planning.world.mechanics.simulation import Simulation
    from planning.world.models.model_library import ModelLibrary, bundled_folder
    from planning.world.models.model_list import describe_model, list_models
    from planning.world.replay.replay_writer import replay_html
    from planning.world.world import World

_DOORS = {
    "AddObject": "planning.domain.scene.scene_operation",
    "AllowPair": "planning.domain.scene.scene_operation",
    "AttachObject": "planning.domain.scene.scene_operation",
    "AttemptPool": "planning.domain.request.attempt_pool",
    "CertifyOptions": "planning.domain.request.options",
    "ClearanceWish": "planning.domain.request.options",
    "ConfigurationGoal": "planning.domain.goals.goal",
    "ConfigurationQuality": "planning.domain.goals.configuration_quality",
    "CoreLeases": "planning.parallel.core_leases",
    "Deadline": "planning.domain.request.deadline",
    "DetachObject": "planning.domain.scene.scene_operation",
    "Displacement": "planning.domain.goals.linear_moves",
    "DistanceBand": "planning.domain.request.constraint",
    "ForbidPair": "planning.domain.scene.scene_operation",
    "ForkPool": "planning.parallel.fork_pool",
    "GoalPredicate": "planning.domain.goals.goal",
    "IkOptions": "planning.domain.request.options",
    "JointGoal": "planning.domain.goals.goal",
    "KeepIn": "planning.domain.request.constraint",
    "KeepOut": "planning.domain.request.constraint",
    "KeptFiles": "planning.domain.scene.kept_files",
    "LineGoal": "planning.domain.goals.goal",
    "LineTrace": "planning.domain.goals.line_trace",
    "LockedJoints": "planning.domain.request.constraint",
    "ModelLibrary": "planning.world.models.model_library",
    "MotionPlan": "planning.domain.report.motion_plan",
    "MotionSeries": "planning.api.motion_series",
    "MoveObject": "planning.domain.scene.scene_operation",
    "OrientationCone": "planning.domain.request.constraint",
    "PathPredicate": "planning.domain.request.constraint",
    "Payload": "planning.domain.robot.payload",
    "PlacedBox": "planning.domain.request.constraint",
    "PlannerCard": "planning.domain.planner.planner_card",
    "PlanningProblem": "planning.domain.request.problem",
    "Pose": "planning.domain.geometry.pose",
    "PoseBall": "planning.domain.goals.goal",
    "PoseGoal": "planning.domain.goals.goal",
    "PoseMetric": "planning.domain.request.options",
    "PoseTarget": "planning.domain.goals.goal",
    "PositionBand": "planning.domain.request.constraint",
    "Progress": "planning.domain.report.motion_plan",
    "ProvenMotion": "planning.api.splice_motion",
    "RefineOptions": "planning.domain.request.options",
    "RegionGoal": "planning.domain.goals.goal",
    "RegionOptions": "planning.domain.planner.regions",
    "Regions": "planning.domain.planner.regions",
    "RelativeGoal": "planning.domain.goals.goal",
    "RemoveObject": "planning.domain.scene.scene_operation",
    "RetimeOptions": "planning.domain.request.options",
    "RetimedPath": "planning.api.retime_path",
    "Roadmap": "planning.domain.planner.roadmap",
    "RoadmapCache": "planning.roadmaps.roadmap_cache",
    "RoadmapOptions": "planning.domain.request.options",
    "RoadmapStore": "planning.roadmaps.roadmap_cache",
    "Sampling": "planning.domain.curves.sampling",
    "Scene": "planning.domain.scene.scene",
    "SceneDocument": "planning.world.documents.scene_document",
    "SearchOptions": "planning.domain.request.options",
    "SetPositions": "planning.domain.scene.scene_operation",
    "Simulation": "planning.world.mechanics.simulation",
    "SpeedZone": "planning.domain.request.motion_limits",
    "Steering": "planning.domain.robot.steering",
    "TightLimits": "planning.domain.request.constraint",
    "TimedTrajectory": "planning.domain.curves.curve",
    "ToolLimit": "planning.domain.request.motion_limits",
    "TraceResolution": "planning.api.line",
    "World": "planning.world.world",
    "assess_configurations": "planning.api.ik",
    "build_roadmap": "planning.roadmaps.load_or_build",
    "bundled_folder": "planning.world.models.model_library",
    "certify_positions": "planning.api.certify_trajectory",
    "certify_trajectory": "planning.api.certify_trajectory",
    "check_configurations": "planning.world.check",
    "describe_model": "planning.world.models.model_list",
    "edit_scene": "planning.world.documents.scene_edit",
    "forward_kinematics": "planning.world.mechanics.kinematics",
    "funnel_evidence": "planning.domain.goals.funnel",
    "funnel_summary": "planning.domain.goals.funnel",
    "grow_regions": "planning.api.grow_regions",
    "kernel_name": "planning.kernel.native",
    "list_models": "planning.world.models.model_list",
    "list_planners": "planning.api.planners",
    "load_world": "planning.world.loading.load_world",
    "motion_series": "planning.api.motion_series",
    "parse_scene": "planning.world.documents.scene_file",
    "plan": "planning.pipeline.plan",
    "polyline_through": "planning.domain.curves.interpolation",
    "read_scene": "planning.world.documents.scene_file",
    "replay_html": "planning.world.replay.replay_writer",
    "retime_path": "planning.api.retime_path",
    "reverse_plan": "planning.api.reverse_plan",
    "sample_motion": "planning.api.sample_motion",
    "sample_plan": "planning.api.sample_motion",
    "scene_document": "planning.world.documents.scene_writer",
    "solve_ik": "planning.api.ik",
    "splice_motion": "planning.api.splice_motion",
    "stop_motion": "planning.api.splice_motion",
    "trace_line": "planning.api.line",
    "trajectory_through": "planning.domain.curves.interpolation",
    "unproven_samples": "planning.api.sample_motion",
    "with_line": "planning.world.documents.scene_file",
}

__all__ = [
    "AddObject",
    "AllowPair",
    "AttachObject",
    "AttemptPool",
    "CertifyOptions",
    "ClearanceWish",
    "ConfigurationGoal",
    "ConfigurationQuality",
    "CoreLeases",
    "Deadline",
    "DetachObject",
    "Displacement",
    "DistanceBand",
    "ForbidPair",
    "ForkPool",
    "GoalPredicate",
    "IkOptions",
    "JointGoal",
    "KeepIn",
    "KeepOut",
    "KeptFiles",
    "LineGoal",
    "LineTrace",
    "LockedJoints",
    "ModelLibrary",
    "MotionPlan",
    "MotionSeries",
    "MoveObject",
    "OrientationCone",
    "PathPredicate",
    "Payload",
    "PlacedBox",
    "PlannerCard",
    "PlanningProblem",
    "Pose",
    "PoseBall",
    "PoseGoal",
    "PoseMetric",
    "PoseTarget",
    "PositionBand",
    "Progress",
    "ProvenMotion",
    "RefineOptions",
    "RegionGoal",
    "RegionOptions",
    "Regions",
    "RelativeGoal",
    "RemoveObject",
    "RetimeOptions",
    "RetimedPath",
    "Roadmap",
    "RoadmapCache",
    "RoadmapOptions",
    "RoadmapStore",
    "Sampling",
    "Scene",
    "SceneDocument",
    "SearchOptions",
    "SetPositions",
    "Simulation",
    "SpeedZone",
    "Steering",
    "TightLimits",
    "TimedTrajectory",
    "ToolLimit",
    "TraceResolution",
    "World",
    "assess_configurations",
    "build_roadmap",
    "bundled_folder",
    "certify_positions",
    "certify_trajectory",
    "check_configurations",
    "describe_model",
    "edit_scene",
    "forward_kinematics",
    "funnel_evidence",
    "funnel_summary",
    "grow_regions",
    "kernel_name",
    "list_models",
    "list_planners",
    "load_world",
    "motion_series",
    "parse_scene",
    "plan",
    "polyline_through",
    "read_scene",
    "replay_html",
    "retime_path",
    "reverse_plan",
    "sample_motion",
    "sample_plan",
    "scene_document",
    "solve_ik",
    "splice_motion",
    "stop_motion",
    "trace_line",
    "trajectory_through",
    "unproven_samples",
    "with_line",
]


def __getattr__(name: str) -> Any:
    """Open a door (PEP 562)."""
    if name not in _DOORS:
        message = f"module 'planning' has no attribute {name!r}"
        raise AttributeError(message)
    return getattr(import_module(_DOORS[name]), name)
