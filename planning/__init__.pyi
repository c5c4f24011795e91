# The public names of `planning`, and the modules that define them.

from .api.certify_beside import certify_beside as certify_beside
from .api.certify_rest import certify_rest as certify_rest
from .api.certify_trajectory import certify_trajectory as certify_trajectory
from .api.combine_motions import combine_motions as combine_motions
from .api.gripper_motion import gripper_motion as gripper_motion
from .api.gripper_motion import holding_world as holding_world
from .api.grow_regions import grow_regions as grow_regions
from .api.ik import solve_ik as solve_ik
from .api.retime_path import retime_path as retime_path
from .api.reverse_plan import reverse_plan as reverse_plan
from .api.schedule_motions import schedule_motions as schedule_motions
from .api.splice_motion import splice_motion as splice_motion
from .api.splice_motion import stop_motion as stop_motion
from .api.trace_line import trace_line as trace_line
from .domain.curves.curve import TimedTrajectory as TimedTrajectory
from .domain.curves.interpolation import trajectory_through as trajectory_through
from .domain.geometry.pose import Pose as Pose
from .domain.goals.goal import (
    ConfigurationGoal as ConfigurationGoal,
)
from .domain.goals.goal import (
    GoalPredicate as GoalPredicate,
)
from .domain.goals.goal import (
    JointGoal as JointGoal,
)
from .domain.goals.goal import (
    LineGoal as LineGoal,
)
from .domain.goals.goal import (
    PoseBall as PoseBall,
)
from .domain.goals.goal import (
    PoseGoal as PoseGoal,
)
from .domain.goals.goal import (
    PoseTarget as PoseTarget,
)
from .domain.goals.goal import (
    RegionGoal as RegionGoal,
)
from .domain.goals.goal import (
    RelativeGoal as RelativeGoal,
)
from .domain.goals.linear_moves import Displacement as Displacement
from .domain.planner.regions import RegionOptions as RegionOptions
from .domain.planner.regions import Regions as Regions
from .domain.report.motion_plan import MotionPlan as MotionPlan
from .domain.request.constraint import (
    DistanceBand as DistanceBand,
)
from .domain.request.constraint import (
    KeepIn as KeepIn,
)
from .domain.request.constraint import (
    KeepOut as KeepOut,
)
from .domain.request.constraint import (
    LockedJoints as LockedJoints,
)
from .domain.request.constraint import (
    OrientationCone as OrientationCone,
)
from .domain.request.constraint import (
    PathPredicate as PathPredicate,
)
from .domain.request.constraint import (
    PlacedBox as PlacedBox,
)
from .domain.request.constraint import (
    PositionBand as PositionBand,
)
from .domain.request.constraint import (
    TightLimits as TightLimits,
)
from .domain.request.deadline import Deadline as Deadline
from .domain.request.drake_term import DrakeTerm as DrakeTerm
from .domain.request.gripper_command import GripperCommand as GripperCommand
from .domain.request.group_motion import GroupMotion as GroupMotion
from .domain.request.motion_limits import SpeedZone as SpeedZone
from .domain.request.motion_limits import ToolLimit as ToolLimit
from .domain.request.options import (
    CertifyOptions as CertifyOptions,
)
from .domain.request.options import (
    ClearanceObjective as ClearanceObjective,
)
from .domain.request.options import (
    IkOptions as IkOptions,
)
from .domain.request.options import (
    RefineOptions as RefineOptions,
)
from .domain.request.options import (
    RetimeOptions as RetimeOptions,
)
from .domain.request.options import (
    RoadmapOptions as RoadmapOptions,
)
from .domain.request.options import (
    SearchOptions as SearchOptions,
)
from .domain.request.problem import PlanningProblem as PlanningProblem
from .domain.request.refine_objective import RefineObjective as RefineObjective
from .domain.robot.payload import Payload as Payload
from .domain.robot.steering import Steering as Steering
from .domain.scene.scene import Scene as Scene
from .domain.scene.scene_operation import (
    AddObject as AddObject,
)
from .domain.scene.scene_operation import (
    AllowPair as AllowPair,
)
from .domain.scene.scene_operation import (
    AttachObject as AttachObject,
)
from .domain.scene.scene_operation import (
    DetachObject as DetachObject,
)
from .domain.scene.scene_operation import (
    ForbidPair as ForbidPair,
)
from .domain.scene.scene_operation import (
    MoveObject as MoveObject,
)
from .domain.scene.scene_operation import (
    RemoveObject as RemoveObject,
)
from .domain.scene.scene_operation import (
    SetPositions as SetPositions,
)
from .kernel.native import kernel_name as kernel_name
from .pipeline.plan import plan as plan
from .roadmaps.load_or_build import build_roadmap as build_roadmap
from .roadmaps.roadmap_cache import RoadmapCache as RoadmapCache
from .world.configuration_check import check_configurations as check_configurations
from .world.documents.scene_edit import edit_scene as edit_scene
from .world.documents.scene_file import parse_scene as parse_scene
from .world.documents.scene_file import read_scene as read_scene
from .world.documents.scene_writer import scene_document as scene_document
from .world.loading.load_world import load_world as load_world
from .world.mechanics.kinematics import forward_kinematics as forward_kinematics
from .world.mechanics.simulation import Simulation as Simulation
from .world.models.model_library import (
    ModelLibrary as ModelLibrary,
)
from .world.models.model_library import (
    bundled_folder as bundled_folder,
)
from .world.models.model_list import describe_model as describe_model
from .world.models.model_list import list_models as list_models
from .world.replay.replay_writer import replay_html as replay_html
from .world.scene_summary import scene_summary as scene_summary
from .world.world import World as World
