"""Robots of random joints and shapes, built in Drake, and random motions of them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    Box,
    Capsule,
    CollisionFilterDeclaration,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometrySet,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PlanarJoint,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    SpatialInertia,
)
from pydrake.planning import RobotDiagramBuilder

from planning.certify.certifier import CertifyRequest
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import Joint, JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import Coupling, DrakeModel
from tests.certify.oracles import for_oracle

R, P, PLANAR, FLOATING = (
    JointType.REVOLUTE,
    JointType.PRISMATIC,
    JointType.PLANAR,
    JointType.FLOATING,
)
KINDS = (R, R, R, P, PLANAR, FLOATING)


@dataclass
class Robot:
    """A model, its group and the state, for certify requests."""

    model: DrakeModel
    group: JointGroup
    state: np.ndarray

    def limits(self, rate: float = 1e6) -> JointLimits:
        blocks = tuple(indices for _, indices in self.group.blocks)
        rates = np.full(len(blocks), rate)
        far = np.full(self.group.num_positions, 1e6)
        return JointLimits(-far, far, rates, rates, rates, rates, blocks)

    def request(self, trajectory: TimedTrajectory, margins: PairMargins) -> CertifyRequest:
        """Return the certify request of a trajectory, from its own start to its own end."""
        return CertifyRequest(
            group=self.group,
            trajectory=trajectory,
            state=self.state,
            start=trajectory.start,
            goals=trajectory.end[None],
            limits=self.limits(),
            margins=margins,
            jerk=False,
        )


@dataclass
class Builder:
    """Adds links one by one; link i hangs on link `parent`, or on the world."""

    names: dict[int, str] = field(default_factory=dict)
    joints: list[Any] = field(default_factory=list)
    types: list[JointType] = field(default_factory=list)
    links: list[Any] = field(default_factory=list)
    followers: list[tuple[int, int, float]] = field(default_factory=list)
    mass: float = np.nan

    def __post_init__(self) -> None:
        self.builder: Any = RobotDiagramBuilder(time_step=0.0)
        self.plant = self.builder.plant()
        self.filtered: list[tuple[Any, Any]] = []

    def body(self, name: str, shape: Shape, x_bg: RigidTransform | None = None) -> Any:
        inertia = SpatialInertia.NaN()
        if np.isfinite(self.mass):
            inertia = SpatialInertia.SolidBoxWithMass(self.mass, 0.1, 0.2, 0.3)
        link = self.plant.AddRigidBody(name, inertia)
        self.names[int(link.index())] = name
        at = x_bg or RigidTransform()
        self.plant.RegisterCollisionGeometry(link, at, shape, name, CoulombFriction(1.0, 1.0))
        return link

    def obstacle(self, name: str, shape: Shape, x_wo: RigidTransform) -> None:
        body = self.body(name, shape)
        self.plant.WeldFrames(self.plant.world_frame(), body.body_frame(), x_wo)

    def link(  # noqa: PLR0913, PLR0917  (a joint has this many parts)
        self,
        kind: JointType,
        shape: Shape,
        parent: int | None = None,
        x_pf: RigidTransform | None = None,
        axis: np.ndarray | None = None,
        x_bm: RigidTransform | None = None,
        x_bg: RigidTransform | None = None,
    ) -> int:
        plant, number = self.plant, len(self.links)
        link = self.body(f"robot::link{number}", shape, x_bg)
        above = plant.world_body() if parent is None else self.links[parent]
        offset = FixedOffsetFrame(f"f{number}", above.body_frame(), x_pf or RigidTransform())
        frame = plant.AddFrame(offset)
        moved = FixedOffsetFrame(f"m{number}", link.body_frame(), x_bm or RigidTransform())
        child = plant.AddFrame(moved)
        line = np.array([0.0, 0.0, 1.0]) if axis is None else axis
        joint = {
            R: lambda: RevoluteJoint(f"j{number}", frame, child, line),
            P: lambda: PrismaticJoint(f"j{number}", frame, child, line),
            PLANAR: lambda: PlanarJoint(f"j{number}", frame, child, np.zeros(3)),
            FLOATING: lambda: QuaternionFloatingJoint(f"j{number}", frame, child),
        }[kind]()
        self.joints.append(plant.AddJoint(joint))
        self.types.append(kind)
        self.links.append(link)
        if parent is not None:
            self.filtered.append((above, link))
        return number

    def build(self) -> Robot:
        """Return the robot; joints that follow others are not of its group."""
        self.plant.Finalize()
        filters = self.builder.scene_graph().collision_filter_manager()
        for pair in self.filtered:
            a, b = (GeometrySet(self.plant.GetCollisionGeometriesForBody(x)) for x in pair)
            filters.Apply(CollisionFilterDeclaration().ExcludeBetween(a, b))
        scene_graph = self.builder.scene_graph()
        following = {follower for follower, _, _ in self.followers}
        members = [i for i in range(len(self.joints)) if i not in following]
        joints = tuple(Joint(f"robot::j{i}", self.types[i]) for i in members)
        couplings = tuple(
            Coupling(
                self.joints[f].position_start(),
                self.joints[m].position_start(),
                self.joints[f].velocity_start(),
                self.joints[m].velocity_start(),
                multiplier,
                0.0,
            )
            for f, m, multiplier in self.followers
        )
        plant = self.plant
        bodies = {
            name: plant.get_body(plant.GetBodyByName(name).index()).index()
            for name in self.names.values()
        }
        made = DrakeModel(
            diagram=self.builder.Build(),
            plant=plant,
            scene_graph=scene_graph,
            body_names={index: name for name, index in bodies.items()},
            bodies=bodies,
            frames={},
            joint_indices={f"robot::j{i}": joint.index() for i, joint in enumerate(self.joints)},
            couplings=couplings,
        )
        model, context = for_oracle(made), plant.CreateDefaultContext()
        return Robot(model, JointGroup("robot", joints, ()), plant.GetPositions(context))


def random_pose(rng: np.random.Generator, spread: float) -> RigidTransform:
    quaternion = rng.normal(size=4)
    position = rng.normal(0.0, spread, 3)
    return RigidTransform(Quaternion(quaternion / np.linalg.norm(quaternion)), position)


def random_shape(rng: np.random.Generator, size: float) -> Shape:
    a, b, c = rng.uniform(0.3, 1.0, 3) * size
    points = np.asfortranarray(rng.normal(0.0, size / 2, (3, 12)))
    shapes = (Box(a, b, c), Sphere(a), Cylinder(a, b), Capsule(a, b), Ellipsoid(a, b, c))
    choice = int(rng.integers(len(shapes) + 1))
    return shapes[choice] if choice < len(shapes) else Convex(points, "hull")


def random_robot(
    rng: np.random.Generator, num_links: int, num_obstacles: int, mass: float = np.nan
) -> Robot:
    """Return a tree of random joints among random obstacles; a mimic joint may be in it."""
    builder = Builder(mass=mass)
    for i in range(num_links):
        parent = None if i == 0 else int(rng.integers(i))
        axis = rng.normal(size=3)
        builder.link(
            KINDS[int(rng.integers(len(KINDS)))],
            random_shape(rng, 0.1),
            parent,
            random_pose(rng, 0.2),
            axis / np.linalg.norm(axis),
            random_pose(rng, 0.1),
            random_pose(rng, 0.05),
        )
    scalar = [i for i, kind in enumerate(builder.types) if kind in (R, P)]
    if len(scalar) > 1:
        builder.followers.append((scalar[-1], scalar[0], -1.5))
    for joint in [] if np.isnan(mass) else [builder.joints[i] for i in scalar]:
        joint.set_default_damping(float(rng.uniform(0.0, 2.0)))
        drive = builder.plant.AddJointActuator(f"drive of {joint.name()}", joint)
        drive.set_default_rotor_inertia(float(rng.uniform(0.0, 0.1)))
    for i in range(num_obstacles):
        builder.obstacle(f"obstacle{i}", random_shape(rng, 0.15), random_pose(rng, 0.6))
    return builder.build()


def random_trajectory(
    rng: np.random.Generator, group: JointGroup, num_pieces: int, spread: float
) -> TimedTrajectory:
    """Return a motion from rest to rest in continuous pieces of degree 5, each anchored anew."""
    manifold = Manifold(group.joints)
    q = np.zeros(group.num_positions)
    begin = 0
    for joint in group.joints:
        if joint.type is FLOATING:
            q[begin] = 1.0
        begin += joint.num_positions
    q = manifold.plus(q, rng.normal(0.0, spread, manifold.num_velocities))
    widths = rng.uniform(0.2, 1.0, num_pieces)
    bases, coefficients = [], []
    for width in widths:
        delta = rng.normal(0.0, spread, manifold.num_velocities)
        piece = np.zeros((6, manifold.num_velocities))
        for power, factor in ((3, 10.0), (4, -15.0), (5, 6.0)):
            piece[power] = factor * delta / width**power
        # A wiggle that is gone, with its slope, at both ends: x^2 (1 - x)^2.
        wiggle = rng.normal(0.0, spread, manifold.num_velocities)
        for power, factor in ((2, 16.0), (3, -32.0), (4, 16.0)):
            piece[power] += factor * wiggle / width**power
        bases.append(q)
        coefficients.append(piece)
        q = manifold.normalized(manifold.plus(q, delta))
    breaks = np.concatenate([[0.0], np.cumsum(widths)])
    return TimedTrajectory(group.joints, breaks, np.array(bases), np.array(coefficients))


def fine_loop(robot: Robot, trajectory: TimedTrajectory, step: float = 0.002) -> float:
    """Return the smallest signed distance at samples at most `step` rad or m apart.

    It shares nothing with the certifier but Drake's query; pairs that nothing moves count as well.
    """
    plant, scene_graph = robot.model.plant, robot.model.scene_graph
    context = robot.model.diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    coarse = trajectory.tangents(np.linspace(0, trajectory.duration, 400))
    steps = np.abs(np.diff(coarse, axis=0))
    # From piece to piece the tangent starts again: such steps are no motion.
    length = float(steps.max(axis=1)[steps.max(axis=1) < 0.5].sum())
    count = max(100, int(length / step))
    smallest = np.inf
    for q in trajectory.positions(np.linspace(0, trajectory.duration, count)):
        plant.SetPositions(plant_context, robot.model.embed(robot.group, q, robot.state))
        query: Any = scene_graph.get_query_output_port().Eval(
            scene_graph.GetMyContextFromRoot(context)
        )
        pairs = query.ComputeSignedDistancePairwiseClosestPoints(0.2)
        smallest = min([smallest, *(pair.distance for pair in pairs)])
    return smallest
