"""Motion planning that proves what it plans: load a world, plan, check, solve IK, execute.

These names are the doors; what lies behind them may move. Drake, OMPL, toppra and ruckig are
imported when a door that needs them is first opened, so that `import planning` stays light.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planning.domain.constraint import (
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
    from planning.domain.curve import TimedTrajectory
    from planning.domain.deadline import Deadline
    from planning.domain.funnel import funnel_evidence, funnel_summary
    from planning.domain.goal import (
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
    from planning.domain.interpolation import polyline_through, trajectory_through
    from planning.domain.kept_files import KeptFiles
    from planning.domain.line import Displacement
    from planning.domain.line_trace import LineTrace
    from planning.domain.motion_limits import SpeedZone, ToolLimit
    from planning.domain.options import (
        CertifyOptions,
        ClearanceWish,
        IkOptions,
        PoseMetric,
        RefineOptions,
        RetimeOptions,
        RoadmapOptions,
        SearchOptions,
    )
    from planning.domain.payload import Payload
    from planning.domain.plan import MotionPlan, Progress
    from planning.domain.planner_card import PlannerCard
    from planning.domain.pool import AttemptPool
    from planning.domain.pose import Pose
    from planning.domain.problem import PlanningProblem
    from planning.domain.quality import ConfigurationQuality
    from planning.domain.regions import RegionOptions, Regions
    from planning.domain.roadmap import Roadmap
    from planning.domain.sampling import Sampling
    from planning.domain.scene import Scene
    from planning.domain.scene_operation import (
        AddObject,
        AllowPair,
        AttachObject,
        DetachObject,
        ForbidPair,
        MoveObject,
        RemoveObject,
        SetPositions,
    )
    from planning.domain.steering import Steering
    from planning.fork_pool import ForkPool
    from planning.growing import grow_regions
    from planning.ik import assess_configurations, solve_ik
    from planning.kernel.native import kernel_name
    from planning.line import Fineness, trace_line
    from planning.own_path import RetimedPath, retime_path
    from planning.own_trajectory import certify_positions, certify_trajectory
    from planning.pipeline import plan
    from planning.planners import list_planners
    from planning.reverse import reverse_plan
    from planning.roadmap_shelf import RoadmapShelf, RoadmapStore
    from planning.roadmaps import build_roadmap
    from planning.sampled_motion import (
        sample_motion,
        sample_plan,
        unproven_samples,
    )
    from planning.series import MotionSeries, motion_series
    from planning.shared_cores import SharedCores
    from planning.splice import ProvenMotion, splice_motion, stop_motion
    from planning.world.catalogue import describe_model, list_models
    from planning.world.check import check_configurations
    from planning.world.kinematics import forward_kinematics
    from planning.world.loading import load_world
    from planning.world.model_library import ModelLibrary, bundled_folder
    from planning.world.replay import replay_html
    from planning.world.scene_document import SceneDocument
    from planning.world.scene_edit import edit_scene
    from planning.world.scene_file import parse_scene, read_scene, with_line
    from planning.world.scene_writer import scene_document
    from planning.world.simulation import Simulation
    from planning.world.world import World

_DOORS = {
    "AddObject": "planning.domain.scene_operation",
    "AllowPair": "planning.domain.scene_operation",
    "AttachObject": "planning.domain.scene_operation",
    "AttemptPool": "planning.domain.pool",
    "CertifyOptions": "planning.domain.options",
    "ClearanceWish": "planning.domain.options",
    "ConfigurationGoal": "planning.domain.goal",
    "ConfigurationQuality": "planning.domain.quality",
    "Deadline": "planning.domain.deadline",
    "DetachObject": "planning.domain.scene_operation",
    "Displacement": "planning.domain.line",
    "DistanceBand": "planning.domain.constraint",
    "Fineness": "planning.line",
    "ForbidPair": "planning.domain.scene_operation",
    "ForkPool": "planning.fork_pool",
    "GoalPredicate": "planning.domain.goal",
    "IkOptions": "planning.domain.options",
    "JointGoal": "planning.domain.goal",
    "KeepIn": "planning.domain.constraint",
    "KeepOut": "planning.domain.constraint",
    "KeptFiles": "planning.domain.kept_files",
    "LineGoal": "planning.domain.goal",
    "LineTrace": "planning.domain.line_trace",
    "LockedJoints": "planning.domain.constraint",
    "ModelLibrary": "planning.world.model_library",
    "MotionPlan": "planning.domain.plan",
    "MotionSeries": "planning.series",
    "MoveObject": "planning.domain.scene_operation",
    "OrientationCone": "planning.domain.constraint",
    "PathPredicate": "planning.domain.constraint",
    "Payload": "planning.domain.payload",
    "PlacedBox": "planning.domain.constraint",
    "PlannerCard": "planning.domain.planner_card",
    "PlanningProblem": "planning.domain.problem",
    "Pose": "planning.domain.pose",
    "PoseBall": "planning.domain.goal",
    "PoseGoal": "planning.domain.goal",
    "PoseMetric": "planning.domain.options",
    "PoseTarget": "planning.domain.goal",
    "PositionBand": "planning.domain.constraint",
    "Progress": "planning.domain.plan",
    "ProvenMotion": "planning.splice",
    "RefineOptions": "planning.domain.options",
    "RegionGoal": "planning.domain.goal",
    "RegionOptions": "planning.domain.regions",
    "Regions": "planning.domain.regions",
    "RelativeGoal": "planning.domain.goal",
    "RemoveObject": "planning.domain.scene_operation",
    "RetimeOptions": "planning.domain.options",
    "RetimedPath": "planning.own_path",
    "Roadmap": "planning.domain.roadmap",
    "RoadmapOptions": "planning.domain.options",
    "RoadmapShelf": "planning.roadmap_shelf",
    "RoadmapStore": "planning.roadmap_shelf",
    "Sampling": "planning.domain.sampling",
    "Scene": "planning.domain.scene",
    "SceneDocument": "planning.world.scene_document",
    "SearchOptions": "planning.domain.options",
    "SetPositions": "planning.domain.scene_operation",
    "SharedCores": "planning.shared_cores",
    "Simulation": "planning.world.simulation",
    "SpeedZone": "planning.domain.motion_limits",
    "Steering": "planning.domain.steering",
    "TightLimits": "planning.domain.constraint",
    "TimedTrajectory": "planning.domain.curve",
    "ToolLimit": "planning.domain.motion_limits",
    "World": "planning.world.world",
    "assess_configurations": "planning.ik",
    "build_roadmap": "planning.roadmaps",
    "bundled_folder": "planning.world.model_library",
    "certify_positions": "planning.own_trajectory",
    "certify_trajectory": "planning.own_trajectory",
    "check_configurations": "planning.world.check",
    "describe_model": "planning.world.catalogue",
    "edit_scene": "planning.world.scene_edit",
    "forward_kinematics": "planning.world.kinematics",
    "funnel_evidence": "planning.domain.funnel",
    "funnel_summary": "planning.domain.funnel",
    "grow_regions": "planning.growing",
    "kernel_name": "planning.kernel.native",
    "list_models": "planning.world.catalogue",
    "list_planners": "planning.planners",
    "load_world": "planning.world.loading",
    "motion_series": "planning.series",
    "parse_scene": "planning.world.scene_file",
    "plan": "planning.pipeline",
    "polyline_through": "planning.domain.interpolation",
    "read_scene": "planning.world.scene_file",
    "replay_html": "planning.world.replay",
    "retime_path": "planning.own_path",
    "sample_motion": "planning.sampled_motion",
    "sample_plan": "planning.sampled_motion",
    "reverse_plan": "planning.reverse",
    "scene_document": "planning.world.scene_writer",
    "solve_ik": "planning.ik",
    "splice_motion": "planning.splice",
    "stop_motion": "planning.splice",
    "trace_line": "planning.line",
    "trajectory_through": "planning.domain.interpolation",
    "unproven_samples": "planning.sampled_motion",
    "with_line": "planning.world.scene_file",
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
    "Deadline",
    "DetachObject",
    "Displacement",
    "DistanceBand",
    "Fineness",
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
    "RoadmapOptions",
    "RoadmapShelf",
    "RoadmapStore",
    "Sampling",
    "Scene",
    "SceneDocument",
    "SearchOptions",
    "SetPositions",
    "SharedCores",
    "Simulation",
    "SpeedZone",
    "Steering",
    "TightLimits",
    "TimedTrajectory",
    "ToolLimit",
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
