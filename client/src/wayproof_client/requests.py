"""What a server is asked. Made by `python -m client.generator`: never edit it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NotRequired, TypedDict


class AddOperation(TypedDict):
    """Add an object."""

    object: ObjectDocument
    """Object as in a scene document, with a name that is free."""
    op: Literal["add"]
    """Kind of the operation."""


class AllowOperation(TypedDict):
    """Let two bodies touch."""

    op: Literal["allow"]
    """Kind of the operation."""
    pair: Sequence[str]
    """Full names of the bodies."""


class AttachOperation(TypedDict):
    """Let a robot hold an object: from now on it follows a frame and counts as the robot's
    body."""

    frame: str
    """`robot::link`, or a frame that hangs on one."""
    grip: NotRequired[GripDocument | None]
    """Contact that holds it in simulations; null for a weld."""
    keep: NotRequired[bool]
    """Whether the object stays where it is in the world at the scene's positions."""
    object: str
    """Name of the object; it must be `movable`."""
    op: Literal["attach"]
    """Kind of the operation."""
    pose: NotRequired[PoseDocument | None]
    """X_FO, pose of the object in the frame; required without `keep`, and not allowed with it."""
    touch: NotRequired[Sequence[str] | None]
    """Bodies that it may touch; by default those that move rigidly with the frame and those
    that they carry outside the robot's default group, such as fingers."""


class AttachmentDocument(TypedDict):
    """Attachment of an object to a robot."""

    frame: str
    """Frame that the object follows: `robot::link`, or a frame with one as ancestor."""
    grip: NotRequired[GripDocument | None]
    """Contact that holds it; none for a weld. Plans and proofs take it to be welded either way,
    and a simulated robot may lose what is held by contact."""
    touch: NotRequired[Sequence[str] | None]
    """Bodies that it may touch; by default those that move rigidly with the frame and those
    that they carry outside the robot's default group, such as fingers."""


class BatchRequest(TypedDict):
    """Problems to plan, all of which are queued, or none."""

    problems: Sequence[PlanRequest]
    """Each as `POST /v1/plans` takes it."""


class Box(TypedDict):
    """A box, placed by the pose of its middle."""

    pose: NotRequired[Pose]
    """Pose of its middle; in a frame that moves with the group, as the start puts it."""
    size: Sequence[float]
    """Full side lengths along the axes of `pose` [m]."""


class Car(TypedDict):
    """A planar base that moves like a car: never sideways, in no tighter turn than it can."""

    reverse: NotRequired[bool]
    """Whether it drives backwards too (Reeds and Shepp's curves) or not (Dubins')."""
    turning_radius: float
    """Radius of its tightest turn, at the origin of the base [m]."""


class Certify(TypedDict):
    """Computations on the motion once it is proven; the report on `certify` has their results."""

    max_stopping_time: NotRequired[float | None]
    """Longest time that a stop may take [s]; it implies `stop_anywhere`; null for no bound."""
    robustness: NotRequired[bool]
    """Whether to bound how far off obstacles and joints may be: `robustness` in the report;
    takes about 0.2 s."""
    stop_anywhere: NotRequired[bool]
    """Whether to bound the longest stop along the path, from any instant: a check `stop`, and
    `stop` in the report. It takes about 0.1 s, 0.5 s with jerk limits, and as much again with
    `effort` or accelerations in `tool_limits`."""


class CertifyMotionRequest(TypedDict):
    """Prove a trajectory of your own."""

    acceleration_bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest (below 0) and highest (above 0) acceleration, by name of a joint with one
    coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]."""
    acceleration_scale: NotRequired[float]
    """Factor on every acceleration and jerk limit, 0..1."""
    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    certify: NotRequired[Certify]
    """Computations besides the proof."""
    effort: NotRequired[bool]
    """Whether joint torques and forces must stay within their limits, gravity and all that is
    carried included: check `torque` of the certificate."""
    goal: NotRequired[Sequence[float] | None]
    """Positions at which the motion shall end [rad or m]; null for those at which it ends."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    limit_jerk: NotRequired[bool]
    """Whether to check the limits on jerk as well."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints on the whole motion; those relative to the start are relative to the first
    configuration of the given path or motion."""
    payload: NotRequired[Payload | None]
    """Mass that the group carries and the scene does not show; it counts for torques."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    scene: str
    """Id of a scene."""
    speed_zones: NotRequired[Sequence[SpeedZone]]
    """Boxes in which a frame is slower."""
    start: NotRequired[Sequence[float] | None]
    """Positions at which the motion shall begin [rad or m]; null for those at which it begins."""
    tool_limits: NotRequired[Sequence[ToolLimit]]
    """Largest speeds and accelerations of frames."""
    trajectory: TrajectoryInput
    """The motion; its `interpolation` says what is between the samples, and straight lines are
    only held to what corners can keep. Positions are numbers, not angles on a circle: from 3 to
    -3 is a way of 6 rad."""
    velocity_scale: NotRequired[float]
    """Factor on every velocity limit, 0..1."""


class CheckRequest(TypedDict):
    """Check configurations of a group against limits and collisions."""

    configurations: Sequence[Sequence[float]]
    """The group's positions, one row each [rad or m]."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""


class ClearanceObjective(TypedDict):
    """Clearance that is preferred, beyond the margin that is required."""

    distance: float
    """Preferred distance between bodies, except between those of one robot [m]."""
    weight: float
    """Extra duration that one metre less of shortfall is worth [s/m]; the shortfall is what the
    clearance lacks of `distance`, on average along the motion."""


class ConfigurationDocument(TypedDict):
    """A named configuration of a group."""

    group: str
    """`robot`, `robot::group`, or a group of `groups`."""
    positions: Sequence[float]
    """Positions in the group's order [rad or m]."""


class ConfigurationGoal(TypedDict):
    """Reach a configuration that the scene or the robot names."""

    name: str
    """Name of the configuration, for example `home`."""
    type: Literal["configuration"]
    """Kind of goal."""


type Constraint = (
    DistanceBand | KeepOut | KeepIn | Position | Orientation | LockedJoints | JointLimits
)
"""Constraint on a whole motion."""


class ConvexDocument(TypedDict):
    """The convex hull of points."""

    points: Sequence[Sequence[float]]
    """Points [m]; not all in one plane."""


class DetachOperation(TypedDict):
    """Leave an object where it is in the world at the scene's positions."""

    object: str
    """Name of the object."""
    op: Literal["detach"]
    """Kind of the operation."""


class Deviation(TypedDict):
    """Deviation of a tool from its line that is allowed, between waypoints and samples too."""

    position: NotRequired[float]
    """Distance of the tool's origin from the line [m]."""
    rotation: NotRequired[float]
    """Angle between the tool's rotation and that of the line [rad]."""


class Displacement(TypedDict):
    """A displacement: a translation, a rotation, or both."""

    position: NotRequired[Sequence[float] | None]
    """Translation [m]; null for none."""
    quaternion: NotRequired[Sequence[float] | None]
    """Rotation as [w, x, y, z]; normalised when read, never zero."""
    rpy: NotRequired[Sequence[float] | None]
    """Rotation as roll, pitch, yaw about fixed x, y, z [rad]."""


class DistanceBand(TypedDict):
    """The smallest distance between two sets of bodies stays within bounds."""

    bodies: NotRequired[Sequence[str] | None]
    """Full names of the first set of bodies; null for all bodies that the group moves."""
    max: NotRequired[float | None]
    """Largest value of the smallest distance [m]; null for no bound."""
    min: NotRequired[float]
    """Least distance that any two of them keep [m]."""
    to: NotRequired[Sequence[str] | None]
    """Full names of the second set of bodies; null for all not in `bodies`."""
    type: Literal["distance_band"]
    """Kind of constraint."""


type DriverName = Literal["simulated", "kinematic"]
"""Driver of a motion: `simulated` is Drake's simulation under a joint controller; `kinematic`
is a robot without mass that is always where it should be, and feels nothing."""


class EmptyDocument(TypedDict):
    """No parameters."""


class ExecutionRequest(TypedDict):
    """Carry out a plan, several plans as one motion, a motion of your own, or that of a
    gripper."""

    delays: NotRequired[Sequence[float] | None]
    """Time at which each of `plans` begins [s]; null for the smallest delays that are proven,
    as `POST /trajectories/schedule` finds them."""
    driver: NotRequired[DriverName | UrRtdeDriver]
    """Driver of the motion."""
    gripper: NotRequired[GripperRequest | None]
    """Open or close a gripper, from where its fingers are, and take hold of an object or let it
    go."""
    on_conflict: NotRequired[Literal["stop", "slow", "replan", "ignore"]]
    """Action while it moves if an edit of the scene is in its way: `stop` comes to rest on the
    path and ends (`path_blocked`); `slow` rests before the conflict and goes on once a later
    edit has cleared the way; `replan` does so too, and goes on with a new plan to the same
    configuration, without a rest where that is proven; `ignore` only tells. With `replan`, no
    other robot of the scene may move until it ends."""
    on_not_certified: NotRequired[Literal["refuse", "replan"]]
    """Action if the plan's motion does not begin where the robot is, or is not proven in the
    latest revision: `refuse` answers 409; `replan` waits for a new plan from where the robot is
    to the same configuration (`replanned`), and answers 409 if there is none. With `when_busy:
    wait` that is done once its robots are free; without a plan it ends with the refusal."""
    plan: NotRequired[str | None]
    """Id of a plan that succeeded; null for several, and for a motion of one's own."""
    plans: NotRequired[Sequence[str] | None]
    """Ids of plans of one scene, which are carried out as one motion with one clock, the most
    urgent first; no joint is in two of them."""
    speed: NotRequired[float]
    """Seconds of the motion per second; above 1 the simulation's clock runs faster than real
    time, and the motion stays as it is."""
    title: NotRequired[str | None]
    """Title of the motion in replays of the scene."""
    trajectory: NotRequired[CertifyMotionRequest | None]
    """A motion of your own, as `POST /trajectories/certify` takes it, without `revision`: it is
    proven in the latest one, and refused (`not_certified`) if it is not."""
    when_busy: NotRequired[Literal["refuse", "wait"]]
    """Action if another execution moves one of its robots, or waits for one: `refuse` answers
    409; `wait` begins once they are free, in the order of requests, and is proven then, from
    where they are."""


class FkRequest(TypedDict):
    """Ask where frames are in given configurations."""

    configurations: Sequence[Sequence[float]]
    """The group's positions, one row each [rad or m]."""
    frames: NotRequired[Sequence[str] | None]
    """Any frames of the scene; null for the group's tool frames."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""


class ForbidOperation(TypedDict):
    """No longer let two bodies touch, which the scene allowed."""

    op: Literal["forbid"]
    """Kind of the operation."""
    pair: Sequence[str]
    """Full names of the bodies."""


class FrameDocument(TypedDict):
    """A named pose: a target, a tool point."""

    name: str
    """Name of the frame."""
    parent: NotRequired[str]
    """Parent of the frame: an object, a frame, `robot::link` or `world`."""
    pose: NotRequired[PoseDocument]
    """X_PF, pose of the frame in its parent."""


type Goal = (
    JointGoal | ConfigurationGoal | PoseGoal | RegionGoal | RelativeGoal | LineGoal | PathGoal
)
"""Goal of a motion."""


class Grasp(TypedDict):
    """Close on an object, and hold it from then on."""

    by: NotRequired[Literal["weld", "contact"]]
    """`weld`: it follows the frame as if welded to it; `contact`: a simulated robot holds it by
    friction alone, between fingers that press with `force`, and may lose it (`grasp_lost`).
    Plans and proofs take it to be welded where it is held. `contact` needs the `simulated`
    driver, and an object with a `mass`."""
    frame: NotRequired[str | None]
    """Frame that the object follows from then on; null for the first tool frame of the gripper."""
    friction: NotRequired[float]
    """Of `contact`: coefficient of Coulomb friction a of the object; that of a contact is 2ab /
    (a + b), where the b of the finger is 1 unless its description says otherwise."""
    gap: NotRequired[float]
    """Distance that the nearest finger keeps from the object [m]. The grasp is a weld, not a
    contact, and a simulated robot that touches something is stopped."""
    object: str
    """Name of the object; it must be `movable`, and between the fingers."""
    reach: NotRequired[float]
    """Largest distance of any finger from the object [m]; beyond it the object is not held
    (`grasp_missed`)."""
    slip: NotRequired[float]
    """Of `contact`: largest distance by which the object may move in the gripper before it
    counts as lost [m]. Proofs know nothing of it: bodies may come that much nearer to it."""
    touch: NotRequired[Sequence[str] | None]
    """Bodies that the object may touch then; null for those of `attach`: the fingers, and
    bodies that move rigidly with the frame."""


class GripDocument(TypedDict):
    """Contact by which a gripper holds an object: friction, and nothing else."""

    force: float
    """Force that presses each finger on the object [N]."""
    friction: NotRequired[float]
    """Coefficient of Coulomb friction a of the object; that of a contact is 2ab / (a + b),
    where the b of the finger is 1 unless its description says otherwise."""
    gripper: str
    """Group that is a gripper, `robot::group`."""
    slip: NotRequired[float]
    """Largest distance by which the object may move in the gripper before it counts as lost [m]."""


class GripperRequest(TypedDict):
    """Open or close a gripper, from where its fingers are."""

    force: NotRequired[float | None]
    """Largest force of the motor of the fingers' joint [N], where a driver has forces: one that
    needs more is stopped (`torque_limit_reached`); null for the joint's own limit. With a grasp
    by `contact`, the force that presses each finger on the object."""
    grasp: NotRequired[Grasp | None]
    """Close on an object; once the fingers rest it is attached as `attach` does it, where it
    was measured to be."""
    group: str | Sequence[str]
    """A group that is a gripper: `robot` for its default group, `robot::group`, or a group that
    the scene names; a list of several, or their names joined by `+`, for one group of all their
    joints, in this order."""
    release: NotRequired[str | None]
    """Name of the object to let go of: it is detached once the fingers have opened to `width`."""
    scene: str
    """Id of a scene; it moves in its latest revision."""
    width: NotRequired[float | None]
    """Distance that the fingers shall have [m], from 0 to `gripper.max_width` of the group;
    null to close on the object of `grasp`."""


class Ik(TypedDict):
    """Options of the search for goal configurations."""

    allowed_time: NotRequired[float | None]
    """Time for finding them, or for saying why there is none [s]; null for as long as there is."""
    joint_weights: NotRequired[Mapping[str, float]]
    """Factor on each joint's part of the distance from the start, by full name
    (`robot::joint`); 1 for joints that are not named [1]."""
    max_configurations: NotRequired[int]
    """Number of configurations at most, the nearest to the start of all that are found; as many
    are looked for, but 100 at least, and until 40 in a row are known already."""
    max_trials: NotRequired[int]
    """Largest number of seeds of the solver, over all poses."""
    pose_metric: NotRequired[PoseMetric]
    """Metric of the nearest pose to one that no configuration reaches."""


class IkRequest(TypedDict):
    """Ask for all configurations that reach a pose, a region or a displacement."""

    allowed_time: NotRequired[float]
    """Time after which to stop, with what was found [s]."""
    goal: PoseGoal | RegionGoal | RelativeGoal
    """Goal of the tool frame."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    ik: NotRequired[Ik]
    """Options of the search."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints that solutions shall keep; joints are locked where `start` has them."""
    seed: NotRequired[int]
    """Seed of all randomness."""
    start: NotRequired[Sequence[float] | None]
    """Configuration that distances are measured from [rad or m]; null for the scene's state."""


class JointGoal(TypedDict):
    """Reach a configuration, or any of several."""

    positions: Sequence[float] | Sequence[Sequence[float]]
    """The group's positions, one list or several [rad or m]."""
    type: Literal["joint"]
    """Kind of goal."""


class JointLimits(TypedDict):
    """Some coordinates of the group stay within bounds, besides those of the robot."""

    limits: Mapping[str, Sequence[float]]
    """Smallest and largest position by the name of a joint, or of a coordinate of one that has
    several [rad or m]."""
    type: Literal["joint_limits"]
    """Kind of constraint."""


class KeepIn(TypedDict):
    """The origin of a frame stays in a box."""

    box: Box
    """Box in which the origin must be."""
    frame: str
    """Frame whose origin is meant."""
    type: Literal["keep_in"]
    """Kind of constraint."""


class KeepOut(TypedDict):
    """The origin of a frame stays out of a box."""

    box: Box
    """Box in which the origin must not be."""
    frame: str
    """Frame whose origin is meant."""
    type: Literal["keep_out"]
    """Kind of constraint."""


class LineGoal(TypedDict):
    """Bring a tool frame to a pose, or by a displacement, in a straight line from the start."""

    deviation: NotRequired[Deviation]
    """Largest deviation of the motion from the line, between samples too."""
    displacement: NotRequired[Translation | None]
    """Displacement from where the tool stands; this or `pose`."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    pose: NotRequired[Pose | None]
    """Pose at which the line ends, and the rotation turns along with the translation; this or
    `displacement`."""
    type: Literal["line"]
    """Kind of goal."""


class LineRequest(TypedDict):
    """Move a tool in a straight line, as far as it goes."""

    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    deviation: NotRequired[Deviation]
    """Largest deviation from the line of the straight ways between the waypoints."""
    displacement: NotRequired[Translation | None]
    """Displacement from where the tool stands; this or `pose`."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    max_step: NotRequired[float]
    """Largest distance that the tool moves between waypoints [m]."""
    pose: NotRequired[Pose | None]
    """Pose at which the line ends, and the rotation turns along with the translation; this or
    `displacement`."""
    poses: NotRequired[bool]
    """Whether to answer the tool's poses as well."""
    start: NotRequired[Sequence[float] | None]
    """Positions of the group at first [rad or m]; null for the scene's state."""


class LockedJoints(TypedDict):
    """Some joints of the group stay where the start has them."""

    joints: Sequence[str]
    """Full names."""
    type: Literal["locked_joints"]
    """Kind of constraint."""


class MarginDocument(TypedDict):
    """A distance that two bodies keep, other than the scene's margin."""

    bodies: Sequence[str]
    margin: float
    """Distance that they keep [m]."""


class MeshDocument(TypedDict):
    """A mesh file; its convex hull is what counts."""

    scale: NotRequired[Sequence[float]]
    """Factor on the size, or one factor per axis [1]."""
    uri: str
    """Path of an .obj, .vtk or .gltf file."""


class MoveOperation(TypedDict):
    """Put an object that is not attached elsewhere; frames that hang on it go along."""

    object: str
    """Name of the object."""
    op: Literal["move"]
    """Kind of the operation."""
    pose: PoseDocument
    """X_WO, its new pose in the world."""


class ObjectDocument(TypedDict):
    """An obstacle, or an object to handle."""

    attached: NotRequired[AttachmentDocument | None]
    """Its attachment to a robot; none if it is fixed to the world."""
    center_of_mass: NotRequired[Sequence[float] | None]
    """Center of mass in its frame [m]; none for that of the shape; only with `mass`."""
    color: NotRequired[Sequence[float] | None]
    """RGB or RGBA, each 0 to 1."""
    mass: NotRequired[float | None]
    """Its mass while it is attached [kg]; none for no mass. Its inertia is that of the shape at
    uniform density; a mesh counts as its convex hull."""
    movable: NotRequired[bool]
    """Whether it may be attached."""
    name: str
    """Name of its body and of its frame."""
    pose: NotRequired[PoseDocument]
    """X_WO; of an attached object X_FO, in its frame."""
    shape: ShapeDocument
    """Geometry of the object [m]."""


class Orientation(TypedDict):
    """An axis of a frame stays within an angle of a direction; turns about the axis are free."""

    axis: Sequence[float]
    """Axis in that frame; any length but zero."""
    direction: Sequence[float]
    """Direction in `reference`; any length but zero."""
    frame: str
    """Frame whose axis is meant."""
    reference: NotRequired[str]
    """Frame in whose axes `direction` is given; a frame that moves counts as the start has it."""
    tolerance: float
    """Largest angle between them [rad]."""
    type: Literal["orientation"]
    """Kind of constraint."""


class PathGoal(TypedDict):
    """Bring a tool frame through poses in straight lines, at rest at each."""

    deviation: NotRequired[Deviation]
    """Largest deviation of the motion from the lines, between samples too."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    poses: Sequence[Pose]
    """Poses in this order; frames that move count where the start puts them."""
    type: Literal["path"]
    """Kind of goal."""


class Payload(TypedDict):
    """A rigid mass that follows a frame and burdens every joint that carries it."""

    center_of_mass: NotRequired[Sequence[float]]
    """Center of mass in the frame [m]."""
    frame: str
    """Frame that the mass follows; the group must move it."""
    inertia: NotRequired[Sequence[float]]
    """Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass, along the frame's axes [kg m^2];
    zeros for a point mass."""
    mass: float
    """Mass [kg]."""


class PlanRequest(TypedDict):
    """Move a group of a scene from a start to a goal."""

    certify: NotRequired[Certify]
    """Computations besides the proof."""
    goal: Goal
    """Goal of the motion."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    ik: NotRequired[Ik]
    """Options of the goals stage."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints that the whole motion shall keep, all of them; each has a check of its own in
    the certificate."""
    priority: NotRequired[Priority]
    """Priority among the jobs that wait; clients take turns within it. A job that has waited
    for 30 s goes with the next priority: `low` is delayed by others, never for good."""
    refine: NotRequired[Refine]
    """Options of the refinement."""
    retime: NotRequired[Retime]
    """Options of the timing."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    scene: str
    """Id of a scene."""
    search: NotRequired[Search]
    """Options of the search."""
    seed: NotRequired[int]
    """Seed of all randomness: the same seed gives the same bytes."""
    start: NotRequired[Sequence[float] | None]
    """The group's positions [rad or m]; null for the scene's current state."""


class PolynomialInput(TypedDict):
    """The exact motion, as `Trajectory.polynomial` has it."""

    bases: Sequence[Sequence[float]]
    """Configuration at which each piece is anchored, n rows [rad or m]."""
    breaks: Sequence[float]
    """Instants between pieces, from 0, n + 1 of them [s]."""
    coefficients: Sequence[Sequence[Sequence[float]]]
    """n pieces, powers from 0 up, a column per velocity coordinate."""
    joint_names: NotRequired[Sequence[str] | None]
    """The group's joints in order."""
    joint_types: NotRequired[Sequence[str] | None]
    """Ignored: the scene has them."""


class Pose(TypedDict):
    """A rigid transform in a frame; `quaternion` or `rpy`, or neither for no rotation."""

    frame: NotRequired[str]
    """The frame that the pose is given in: any frame of the scene."""
    position: Sequence[float]
    """x, y, z in `frame` [m]."""
    quaternion: NotRequired[Sequence[float] | None]
    """Rotation as [w, x, y, z]; normalised when read, never zero."""
    rpy: NotRequired[Sequence[float] | None]
    """Rotation as roll, pitch, yaw about fixed x, y, z [rad]."""


class PoseDistanceTolerance(TypedDict):
    """All poses within a weighted distance: sqrt(sum (w_i * way_i)^2 + (w_r * angle)^2)."""

    frame: NotRequired[str | None]
    """Frame in whose axes the way from the target's origin is measured, as they stand at the
    start: any frame; null for the target's own."""
    tolerance: float
    """The largest distance [1]."""
    weights: NotRequired[Sequence[float]]
    """w_x, w_y, w_z [1/m] and w_r [1/rad]; what has no weight is free."""


class PoseDocument(TypedDict):
    """A rigid transform; `quaternion` or `rpy`, or neither for no rotation."""

    position: NotRequired[Sequence[float]]
    """x, y, z [m]."""
    quaternion: NotRequired[Sequence[float] | None]
    """[w, x, y, z], any length > 0."""
    rpy: NotRequired[Sequence[float] | None]
    """roll, pitch, yaw about fixed axes [rad]."""


class PoseGoal(TypedDict):
    """Bring a tool frame to a pose, or to any of several."""

    approach: NotRequired[Sequence[float] | None]
    """Displacement of the tool, in the target's axes, at which the last straight line to the
    goal begins [m]; the tool does not turn on it; null for none."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    metric: NotRequired[PoseDistanceTolerance | None]
    """Tolerance by a weighted metric, instead of `tolerance`."""
    poses: Sequence[Pose]
    """The candidates; `goal_index` of the result says which one was reached."""
    retreat: NotRequired[Sequence[float] | None]
    """Displacement of the tool, in the target's axes, in a straight line after the goal [m];
    null for none."""
    tolerance: NotRequired[Tolerance]
    """Tolerance of the pose."""
    type: Literal["pose"]
    """Kind of goal."""


class PoseMetric(TypedDict):
    """Distance of two poses: sqrt((translation * t)^2 + (rotation * angle)^2)."""

    rotation: NotRequired[float]
    """Weight of a radian [1/rad]; by default one weighs as much as 0.1 m."""
    translation: NotRequired[float]
    """Weight of a metre [1/m]."""


class Position(TypedDict):
    """The origin of a frame stays near a line, a plane or a point."""

    frame: str
    """Frame whose origin is meant."""
    pose: NotRequired[Pose]
    """Pose of its middle; in a frame that moves with the group, as the start puts it."""
    size: Sequence[float | None]
    """Width of the band along each axis of `pose` [m]; null for an axis that is free: one
    number is a plane, two are a line."""
    type: Literal["position"]
    """Kind of constraint."""


type Priority = Literal["low", "normal", "high"]
"""Priority among the jobs that wait."""


class Refine(TypedDict):
    """Options for optimising the path."""

    clearance: NotRequired[ClearanceObjective | None]
    """Clearance that the duration is weighed against; `none` and `drake` have no use for it."""
    method: NotRequired[Literal["trajopt", "drake", "auto", "none"]]
    """Method: convex steps (`trajopt`), Drake's KinematicTrajectoryOptimization (`drake`), as
    `trajopt` but only if at least half a second is left (`auto`), or none, which leaves the
    path as it is."""
    objective: NotRequired[RefineObjective | None]
    """Objective to minimise; null for the duration, the only objective for cars. With it, or
    with `drake`, the report has all objectives, before and after."""


class RefineObjective(TypedDict):
    """Objective to minimise: a weighted sum; at least one weight is positive."""

    derivative: NotRequired[Literal["acceleration", "jerk"]]
    """Derivative that smoothness integrates."""
    duration: NotRequired[float]
    """Weight of the duration [1/s]."""
    energy: NotRequired[float]
    """Weight of the integral over time of the squared norm of the joints' torques and forces,
    gravity, damping and payload included [1/(N^2 m^2 s)]; not for groups with a floating joint."""
    max_duration: NotRequired[float | None]
    """Longest duration of the motion [s], approach and retreat not counted; less than the
    limits allow is `retiming_failed`. Smoothness and energy need it unless the duration has a
    weight."""
    path_length: NotRequired[float]
    """Weight of the joint-space length [1/rad or 1/m]."""
    smoothness: NotRequired[float]
    """Weight of the integral over time of the squared norm of what `derivative` names
    [s^3/rad^2, for jerk s^5/rad^2]."""


class RegionGoal(TypedDict):
    """Bring a tool frame anywhere into a region, or into any of several."""

    approach: NotRequired[Sequence[float] | None]
    """Displacement of the tool, in the region's axes, at which the last straight line to the
    motion's end in the region begins [m]; null for none."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    free_axes: NotRequired[Sequence[Literal["x", "y", "z", "rx", "ry", "rz"]]]
    """Axes of the region that it is unbounded along (`x`, `y`, `z`: as far as the group
    reaches) or free to turn about (`rx`, `ry`, `rz`)."""
    pose: NotRequired[Pose | None]
    """Middle of the only region."""
    poses: NotRequired[Sequence[Pose] | None]
    """Middles of the regions; or one as `pose`."""
    retreat: NotRequired[Sequence[float] | None]
    """Displacement of the tool, in the region's axes, in a straight line after the goal [m];
    null for none."""
    tolerance: NotRequired[Tolerance]
    """Extent of the region from its middle, by its axes."""
    type: Literal["region"]
    """Kind of goal."""


class RegionsRequest(TypedDict):
    """Grow regions for a group of a scene."""

    allowed_time: NotRequired[float]
    """Time after which the regions that have grown are the result [s]."""
    along: NotRequired[Literal["paths", "nothing"]]
    """Regions that come first: those along paths from the scene's state to the group's named
    configurations and the scene's frames (`paths`), or none but the cover (`nothing`)."""
    bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest and highest value to grow in [rad or m], by position name, within the limits;
    angles that may turn further are taken from -pi to pi, those on a circle over one turn at
    most."""
    coverage: NotRequired[float]
    """Coverage at which growth ends, as a share of the free configurations in the domain [1]."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    iterations: NotRequired[int]
    """Number of times that a region is grown anew around its largest ellipsoid."""
    margin: NotRequired[float | None]
    """Distance that regions keep [m]; null for the scene's."""
    num_free: NotRequired[int]
    """Number of consecutive random configurations of a region that must be free."""
    num_regions: NotRequired[int]
    """Largest number of regions."""
    padding: NotRequired[float]
    """Distance beyond the margin, for proofs to be quick [m]."""
    priority: NotRequired[Priority]
    """Priority among the jobs that wait; clients take turns within it. A job that has waited
    for 30 s goes with the next priority: `low` is delayed by others, never for good."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    seed: NotRequired[int]
    """Seed of all randomness: the same seed gives the same regions."""


class RelativeGoal(TypedDict):
    """Move a tool frame by a displacement from where the start has it."""

    displacement: Displacement
    """Displacement from where the tool is at the start."""
    frame: NotRequired[str | None]
    """The tool frame: any that the group moves; null for its default."""
    reference: NotRequired[str | None]
    """Frame in whose axes, as they are at the start, the tool is shifted, and turned about its
    own origin; null for the tool frame itself."""
    type: Literal["relative"]
    """Kind of goal."""


class RemoveOperation(TypedDict):
    """Remove an object, the frames that hang on it, and the pairs and margins that name it."""

    object: str
    """Name of the object."""
    op: Literal["remove"]
    """Kind of the operation."""


class Retime(TypedDict):
    """Options for timing the path."""

    acceleration_bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest (below 0) and highest (above 0) acceleration, by name of a joint with one
    coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]."""
    acceleration_scale: NotRequired[float]
    """Factor on every acceleration and jerk limit, 0..1."""
    deviation: NotRequired[float | None]
    """Largest distance by which corners of the path may be rounded [rad or m, joint-space
    length]; 0 to follow the very path with a rest at every corner, null for at most 0.1.
    Refined paths have no corners."""
    duration: NotRequired[float | None]
    """Duration of the motion [s]; null for the least that the limits allow, and less than that
    is `retiming_failed`."""
    effort: NotRequired[bool]
    """Whether joint torques and forces must stay within their limits, gravity and all that is
    carried included: check `torque` of the certificate."""
    even_samples: NotRequired[bool]
    """Whether to deliver samples exactly `sample_period` apart, but for the last, wherever the
    pieces of the motion meet; `trajectory.interpolations` says what is proven of them."""
    explain: NotRequired[bool]
    """Whether to report which limit binds when, and what relaxing it would save
    (`stages.retime.explanation`), once the motion is proven and if there is time. It takes
    about 20 ms for each part; with ruckig as long as timing it once more for each limit that
    binds, six at most."""
    method: NotRequired[Literal["toppra", "ruckig"]]
    """Method of timing: toppra keeps velocity and acceleration limits; ruckig keeps jerk limits
    too."""
    num_points: NotRequired[int | None]
    """Number of samples to deliver, evenly in time however far apart, first and last instants
    included; null for one every `sample_period`, not both. `trajectory.interpolations` says
    what is proven of them."""
    payload: NotRequired[Payload | None]
    """Mass that the group carries and the scene does not show; it counts for torques."""
    sample_period: NotRequired[float | None]
    """Longest time between delivered samples [s]; null where `num_points` says how many; more
    than 200000 samples are `problem_invalid`. They lie where the pieces of the motion meet, and
    evenly between, so that every interpolation of them can be proven."""
    speed_zones: NotRequired[Sequence[SpeedZone]]
    """Boxes in which a frame is slower."""
    tool_limits: NotRequired[Sequence[ToolLimit]]
    """Largest speeds and accelerations of frames."""
    velocity_scale: NotRequired[float]
    """Factor on every velocity limit, 0..1."""


class RetimeRequest(TypedDict):
    """Time a path of your own, and prove the motion."""

    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    certify: NotRequired[Certify]
    """Computations besides the proof."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints on the whole motion; those relative to the start are relative to the first
    configuration of the given path or motion."""
    polynomial: NotRequired[bool]
    """Whether to add the exact piecewise polynomial."""
    retime: NotRequired[Retime]
    """Options of the timing."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    scene: str
    """Id of a scene."""
    waypoints: Sequence[Sequence[float]]
    """The group's positions from start to goal, joined by straight lines in joint space [rad or
    m]."""


class Roadmap(TypedDict):
    """A roadmap that many plans share; it is built once for a scene as a group sees it."""

    neighbours: NotRequired[int]
    """Number of nearest others that each is joined with, where the way is free."""
    seed: NotRequired[int]
    """Seed of its samples; the plan's own seed does not change it."""
    states: NotRequired[int]
    """Number of free configurations that it has."""


class RobotDocument(TypedDict):
    """A robot in the scene."""

    base: NotRequired[PoseDocument]
    """X_WB, pose at which its base link is welded."""
    model: str
    """Name of a robot (GET /v1/models), or a path of a URDF, SDF or MJCF file."""
    name: str
    """Prefix of its bodies, frames and joints: `name::link`."""
    positions: NotRequired[str | Sequence[float] | Mapping[str, float | Sequence[float]] | None]
    """Name of a configuration, values of its default group, or values by joint."""
    weld: NotRequired[bool | None]
    """Whether its base link is welded to the world at `base`, or floats and starts there. By
    default bases of URDF files are welded, and those of SDF and MJCF files float unless they
    say otherwise themselves."""


class RoundDocument(TypedDict):
    """Radius and length of a cylinder or capsule [m]; the axis is z."""

    length: float
    """Length of the cylindrical part [m]."""
    radius: float
    """Radius [m]."""


type SampleInterpolation = Literal["quintic", "cubic", "cubic_spline", "linear"]
"""Interpolation between two samples."""


class SceneDocument(TypedDict):
    """A scene: robots, obstacles, frames."""

    allowed_collisions: NotRequired[Sequence[Sequence[str]]]
    """Pairs of bodies that may touch."""
    configurations: NotRequired[Mapping[str, ConfigurationDocument]]
    """Named configurations beside those of the robots."""
    frames: NotRequired[Sequence[FrameDocument]]
    groups: NotRequired[Mapping[str, Sequence[str]]]
    """Groups that span groups of robots, `robot` or `robot::group` each, in order."""
    margin: NotRequired[float]
    """Distance kept from everything but the robot itself [m]."""
    margins: NotRequired[Sequence[MarginDocument]]
    """Exceptions from `margin`, by pair."""
    name: NotRequired[str]
    """Name for people."""
    objects: NotRequired[Sequence[ObjectDocument]]
    robots: Sequence[RobotDocument]
    version: NotRequired[Literal[1]]
    """Version of this format."""


class SceneEdit(TypedDict):
    """Operations, carried out in order; all of them or none."""

    operations: Sequence[SceneOperation]
    """Operations, carried out in this order."""
    revision: NotRequired[int | None]
    """The revision that they are meant for; by default the latest, whichever it is."""


type SceneOperation = (
    AddOperation
    | MoveOperation
    | RemoveOperation
    | AttachOperation
    | DetachOperation
    | SetPositionsOperation
    | AllowOperation
    | ForbidOperation
)
"""Operation on a scene, by `op`."""


class ScheduleMotionsRequest(TypedDict):
    """Find when to begin the motions of several plans, so that all of them together are proven."""

    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    limit_jerk: NotRequired[bool]
    """Whether to check the whole against the limits on jerk as well."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    plans: Sequence[str]
    """Ids of plans of groups without a common joint, the most urgent first: the first one waits
    least."""
    polynomial: NotRequired[bool]
    """Whether to add all motions as one, as an exact piecewise polynomial."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    scene: str
    """Id of the scene that all the plans are of."""


class Search(TypedDict):
    """Options for finding a path."""

    allowed_planning_time: NotRequired[float]
    """Time for the whole plan, all stages, from when the scene is loaded [s]; stages that it
    cuts are in `result.cut_short`."""
    approach_states: NotRequired[int]
    """Least number of waypoints of each straight part; `num_states` is then for the free part."""
    approximate: NotRequired[bool]
    """Whether a failure has, as evidence `approximate`, the reached configuration that is
    nearest to a goal."""
    attempts: NotRequired[int]
    """Number of solutions to look for; the best by `objective` is kept. Of several planners
    each has at least one."""
    bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest and highest value to search in [rad or m], by position name, within the limits."""
    interpolate_time: NotRequired[float | None]
    """Time for interpolating each solution to `num_states` [s]; null for as long as there is.
    One that takes longer stays as it was (`stages.search.interpolated`)."""
    keep_graph: NotRequired[bool]
    """Whether the planner's graph is kept for GET /plans/{id}/graph."""
    num_states: NotRequired[int | None]
    """Least number of waypoints to which the path is interpolated."""
    objective: NotRequired[Literal["length", "weighted_length", "clearance", "duration"]]
    """Objective by which solutions are compared, and improved by planners that do so."""
    on_cancel: NotRequired[Literal["discard", "best"]]
    """Scope of a cancel: the plan, or only the search if it has a path by then; that path is
    delivered if it can be timed and proven in 0.9 s."""
    parameters: NotRequired[Mapping[str, bool | int | float | str]]
    """Values of the planner's parameters, by their names in OMPL; of several planners, each
    takes those that it has."""
    planner: NotRequired[str | Sequence[str]]
    """Name of the planner in OMPL, see GET /v1/planners; or several names, which take turns.
    `GCS` plans inside regions, and where it cannot the others do, by default RRTConnect."""
    regions: NotRequired[str | None]
    """Id of the regions that GCS plans in; null for the newest that fit (a plan's `request` has
    the id of those), and where GCS is not among the planners."""
    resolution: NotRequired[float]
    """Largest joint-space distance between two checked states of an edge [rad or m]."""
    roadmap: NotRequired[Roadmap | None]
    """Roadmap in which to look for a path first; the planner is used only where it has none.
    Under `path_constraints` it is one that keeps them."""
    setup_time: NotRequired[float | None]
    """Time for setting up the space and the planner, in each attempt [s]; null for as long as
    it takes. An attempt that took longer gives up."""
    shortcut_time: NotRequired[float | None]
    """Time for shortening each solution [s]; 0 for none, null for a share of the rest."""
    solve_time: NotRequired[float | None]
    """Time for the planner, in each attempt [s]; null for as long as there is."""
    spaces: NotRequired[Mapping[str, Space]]
    """Restrictions of joints, by name: `position` keeps the rotation of a planar or floating
    joint as it is at the start; a turning radius [m] makes a car of a planar joint."""
    weights: NotRequired[Mapping[str, float]]
    """Factors of the metric that planners measure by [1], by name of a joint or of one of the
    group's `blocks`; 1 for what is not named."""


class SetPositionsOperation(TypedDict):
    """Put joints of a robot elsewhere; joints that are not named stay where they are."""

    op: Literal["set_positions"]
    """Kind of the operation."""
    positions: str | Sequence[float] | Mapping[str, float | Sequence[float]]
    """Name of a configuration, values of the default group, or values by joint [rad or m]."""
    robot: str
    """Name of the robot in the scene."""


class ShapeDocument(TypedDict):
    """Exactly one of the shapes."""

    box: NotRequired[Sequence[float] | None]
    """Full side lengths x, y, z [m]."""
    capsule: NotRequired[RoundDocument | None]
    convex: NotRequired[ConvexDocument | None]
    cylinder: NotRequired[RoundDocument | None]
    ellipsoid: NotRequired[Sequence[float] | None]
    """Semi-axes x, y, z [m]."""
    half_space: NotRequired[EmptyDocument | None]
    """All points with z <= 0 in the object's frame."""
    mesh: NotRequired[MeshDocument | None]
    sphere: NotRequired[float | None]
    """Radius [m]."""


type Space = Literal["full", "position"] | Car
"""Part of a joint that is searched, or the curves that a car of it can drive."""


class SpeedRequest(TypedDict):
    """Change how fast a motion is carried out, and which way."""

    speed: float
    """Seconds of the motion per second: 0 rests on the path, negative goes back along it; only
    drivers with a clock of their own go beyond 1 and -1."""


class SpeedZone(TypedDict):
    """Largest speed of the origin of a frame while it is in a box."""

    box: Box
    """Box in which the speed is limited."""
    frame: str
    """Frame whose origin is limited: any frame of the scene."""
    name: str
    """Name for the certificate's check; no two zones share one."""
    speed: float
    """Largest speed in the box [m/s]."""


class SpliceMotionRequest(TypedDict):
    """Go over to another motion; only the limits and constraints of this request are kept."""

    acceleration_bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest (below 0) and highest (above 0) acceleration, by name of a joint with one
    coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]."""
    acceleration_scale: NotRequired[float]
    """Factor on every acceleration and jerk limit, 0..1."""
    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    effort: NotRequired[bool]
    """Whether joint torques and forces must stay within their limits, gravity and all that is
    carried included: check `torque` of the certificate."""
    even_samples: NotRequired[bool]
    """Whether to deliver samples exactly `sample_period` apart, but for the last, wherever the
    pieces of the motion meet; `trajectory.interpolations` says what is proven of them."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    num_points: NotRequired[int | None]
    """Number of samples to deliver, evenly in time however far apart, first and last instants
    included; null for one every `sample_period`, not both. `trajectory.interpolations` says
    what is proven of them."""
    onto: TrajectoryInput
    """The other motion, which is followed to its end."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints on the whole motion; those relative to the start are relative to the first
    configuration of the given path or motion."""
    payload: NotRequired[Payload | None]
    """Mass that the group carries and the scene does not show; it counts for torques."""
    polynomial: NotRequired[bool]
    """Add the exact piecewise polynomial."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    sample_period: NotRequired[float | None]
    """Longest time between delivered samples [s]; null where `num_points` says how many; more
    than 200000 samples are `problem_invalid`. They lie where the pieces of the motion meet, and
    evenly between, so that every interpolation of them can be proven."""
    scene: str
    """Id of a scene."""
    speed_zones: NotRequired[Sequence[SpeedZone]]
    """Boxes in which a frame is slower."""
    time: float
    """Time along the running motion at which it is left, within its duration [s]."""
    tool_limits: NotRequired[Sequence[ToolLimit]]
    """Largest speeds and accelerations of frames."""
    trajectory: TrajectoryInput
    """The running motion, read as `POST /trajectories/certify` reads one."""
    velocity_scale: NotRequired[float]
    """Factor on every velocity limit, 0..1."""


class StopMotionRequest(TypedDict):
    """Stop a running motion; only the limits and constraints of this request are kept."""

    acceleration_bounds: NotRequired[Mapping[str, Sequence[float]]]
    """Lowest (below 0) and highest (above 0) acceleration, by name of a joint with one
    coordinate, or `joint.angular` of a planar one [rad/s^2 or m/s^2]."""
    acceleration_scale: NotRequired[float]
    """Factor on every acceleration and jerk limit, 0..1."""
    allowed_time: NotRequired[float]
    """Time after which to give up [s]."""
    along_path: NotRequired[bool]
    """Whether to stay on the path of the running motion, which is slowed down; else every joint
    brakes by itself."""
    effort: NotRequired[bool]
    """Whether joint torques and forces must stay within their limits, gravity and all that is
    carried included: check `torque` of the certificate."""
    even_samples: NotRequired[bool]
    """Whether to deliver samples exactly `sample_period` apart, but for the last, wherever the
    pieces of the motion meet; `trajectory.interpolations` says what is proven of them."""
    group: str | Sequence[str]
    """`robot` for its default group, `robot::group`, or a group that the scene names; a list of
    several, or their names joined by `+`, for one group of all their joints, in this order."""
    limit_jerk: NotRequired[bool]
    """Whether to keep the limits on jerk, which the running motion must keep too. It can only
    be false along the path, where accelerations then may jump, at the first instant too."""
    margin: NotRequired[float | None]
    """Distance that everything keeps [m]; null for the scene's."""
    num_points: NotRequired[int | None]
    """Number of samples to deliver, evenly in time however far apart, first and last instants
    included; null for one every `sample_period`, not both. `trajectory.interpolations` says
    what is proven of them."""
    path_constraints: NotRequired[Sequence[Constraint]]
    """Constraints on the whole motion; those relative to the start are relative to the first
    configuration of the given path or motion."""
    payload: NotRequired[Payload | None]
    """Mass that the group carries and the scene does not show; it counts for torques."""
    polynomial: NotRequired[bool]
    """Add the exact piecewise polynomial."""
    revision: NotRequired[int | None]
    """Revision of the scene; null for its latest."""
    sample_period: NotRequired[float | None]
    """Longest time between delivered samples [s]; null where `num_points` says how many; more
    than 200000 samples are `problem_invalid`. They lie where the pieces of the motion meet, and
    evenly between, so that every interpolation of them can be proven."""
    scene: str
    """Id of a scene."""
    speed_zones: NotRequired[Sequence[SpeedZone]]
    """Boxes in which a frame is slower."""
    time: float
    """Time along the running motion at which it is left, within its duration [s]."""
    tool_limits: NotRequired[Sequence[ToolLimit]]
    """Largest speeds and accelerations of frames."""
    trajectory: TrajectoryInput
    """The running motion, read as `POST /trajectories/certify` reads one."""
    velocity_scale: NotRequired[float]
    """Factor on every velocity limit, 0..1."""


class Tolerance(TypedDict):
    """Tolerance of the tool frame about a target, in the target's own axes."""

    position: NotRequired[Sequence[float]]
    """Half-widths of a box about the target [m]."""
    rotation: NotRequired[Sequence[float]]
    """Largest rotation about each axis [rad]; pi or more leaves the axis free."""


class ToolLimit(TypedDict):
    """Limits on the speed and acceleration of the origin of a frame."""

    acceleration: NotRequired[float | None]
    """Largest acceleration in any direction [m/s^2]; null for any."""
    frame: str
    """Any frame of the scene; each is limited once."""
    speed: NotRequired[float | None]
    """Largest speed [m/s]; null for any."""


class TrajectoryInput(TypedDict):
    """A timed motion as `Trajectory` has it: samples, or the exact `polynomial`."""

    accelerations: NotRequired[Sequence[Sequence[float]] | None]
    """Accelerations, one row per instant [rad/s^2 or m/s^2]; null if not known."""
    duration: NotRequired[float | None]
    """Ignored: it follows from the times [s]."""
    interpolation: NotRequired[SampleInterpolation | None]
    """Motion between the samples: the polynomials of degree 5 (`quintic`) or 3 (`cubic`) that
    meet what is given, the cubic spline with continuous acceleration that rests at both ends
    (`cubic_spline`), or straight lines (`linear`); null for the first of these that there are
    rates for."""
    interpolations: NotRequired[Sequence[Mapping[str, Any]] | None]
    """Ignored: proofs of the samples, as answers have them."""
    joint_names: NotRequired[Sequence[str] | None]
    """Names of the columns, those of the rates too; null for the group's order."""
    polynomial: NotRequired[PolynomialInput | None]
    """The exact motion; with it the samples are ignored."""
    positions: Sequence[Sequence[float]]
    """One row per instant [rad or m]."""
    times: Sequence[float]
    """Instants of the samples, from 0 [s]."""
    velocities: NotRequired[Sequence[Sequence[float]] | None]
    """Velocities, one row per instant [rad/s or m/s]; null if not known."""
    velocity_names: NotRequired[Sequence[str] | None]
    """Names of the columns of the rates; null for the names of the positions' columns. An order
    that is not the group's needs `joint_names` too."""


class Translation(TypedDict):
    """A translation without a rotation."""

    frame: NotRequired[str]
    """Frame in whose axes the vector is, as they stand at the start."""
    vector: Sequence[float]
    """Translation [m]."""


class UrRtdeDriver(TypedDict):
    """An arm of Universal Robots, by RTDE."""

    host: str
    """Name of a controller in the server's settings (`WAYPROOF_UR_HOSTS`)."""
    type: Literal["ur_rtde"]
    """Protocol of its controller."""


type WebhookEvent = Literal[
    "plan.started",
    "plan.requeued",
    "plan.finished",
    "regions.started",
    "regions.requeued",
    "regions.finished",
    "execution.started",
    "execution.finished",
]
"""Event that a webhook can be told."""


class WebhookRequest(TypedDict):
    """Register an address that is told what happens to jobs."""

    events: NotRequired[Sequence[WebhookEvent]]
    """Events that are told; by default the ends of all jobs."""
    url: str
    """Address to which messages are posted; answer them with a status of 2xx."""
