"""QualityProbe: manipulability, clearance, limit margin, distance and branch of configurations."""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import RevoluteJoint

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.goals.configuration_quality import ArmBranch, ConfigurationQuality
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.goals.arm_branch import branch_of
from planning.goals.joint_metric import JointMetric
from planning.world.kernel.link_tree import link_tree
from planning.world.mechanics.idle_joints import idle_positions
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Search radii for the nearest body pair, tried in turn: a small one is faster, mostly enough [m].
_SEARCH_RADII = (0.1, 10.0)


class QualityProbe:
    """Evaluator of the quality of a group's configurations; it owns a context, so one thread."""

    def __init__(self, world: World, group: JointGroup, frame: str, metric: JointMetric) -> None:
        """Prepare for the manipulability of `frame` and for distances by `metric`."""
        self._world = world
        self._group = group
        self._metric = metric
        self._limits = world.limits(group)
        self._plant = world.drake.plant
        self._kinematics = ToolKinematics(world, group, frame)
        self._diagram_context = world.drake.diagram.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._diagram_context)
        self._distances = world.distance_probe(world.margins())
        self._axes = _arm_axes(world, group, frame)

    def evaluate(
        self, q: Float64[np.ndarray, " nq"], start: Float64[np.ndarray, " nq"]
    ) -> ConfigurationQuality:
        """Return the quality of q; its `distance` is measured from `start`."""
        full = self._world.embed(self._group, q)
        self._plant.SetPositions(self._context, full)
        nearest = self._nearest_pair(full)
        return ConfigurationQuality(
            manipulability=manipulability(self._kinematics.velocity_jacobians(q[None])[0]),
            clearance=None if nearest is None else nearest.distance,
            pair=None if nearest is None else nearest.bodies,
            limit_margin=limit_margin(self._limits, q),
            distance=float(self._metric.distance(q[None], start)[0]),
            branch=self._branch(),
        )

    def _nearest_pair(self, full: Array) -> BodyPair | None:
        for radius in _SEARCH_RADII:
            pairs = self._distances.nearest_within(full, radius)
            if pairs:
                return pairs[0]
        return None

    def _branch(self) -> ArmBranch | None:
        if self._axes is None:
            return None
        poses = [j.frame_on_child().CalcPoseInWorld(self._context) for j in self._axes]
        directions = [
            x.rotation().multiply(j.revolute_axis()) for j, x in zip(self._axes, poses, strict=True)
        ]
        return branch_of(np.stack(directions), np.stack([x.translation() for x in poses]))


def manipulability(jacobian: Float64[np.ndarray, "6 nv"]) -> float:
    """Return the product of the Jacobian's singular values.

    It is sqrt(det(J J^T)) where there are six coordinates or more (Yoshikawa, "Manipulability of
    Robotic Mechanisms", 1985), and sqrt(det(J^T J)) where there are fewer. Zero at a singularity;
    its unit mixes metres and radians, so it compares configurations of one arm only.
    """
    return float(np.prod(np.linalg.svd(jacobian, compute_uv=False)))


def limit_margin(limits: JointLimits, q: Float64[np.ndarray, " nq"]) -> float | None:
    """Return the smallest distance to a position limit, as a share of its range: 0 to 0.5.

    None if no coordinate is limited on both sides.
    """
    span = limits.upper - limits.lower
    bounded = np.isfinite(span) & (span > 0)
    if not bounded.any():
        return None
    gap = np.minimum(q - limits.lower, limits.upper - q)[bounded]
    return float((gap / span[bounded]).min())


def _arm_axes(world: World, group: JointGroup, frame: str) -> list[Any] | None:
    """Return the joints, base to tool, of a serial chain of six revolute joints; None otherwise.

    Of a group that spans several arms, these are the joints that move the frame.
    """
    plant, tree = world.drake.plant, link_tree(world.drake)
    names = [joint.name for joint in group.joints]
    if len(names) > 6:
        idle = idle_positions(world.drake, group, frame)
        idle_names = {name for name, flag in zip(group.position_names, idle, strict=True) if flag}
        names = [name for name in names if name not in idle_names]
    joints: list[Any] = [plant.get_joint(world.drake.joint_indices[name]) for name in names]
    if tree is None or len(joints) != 6:
        return None
    if not all(isinstance(joint, RevoluteJoint) for joint in joints):
        return None
    link_indices = {link.position: i for i, link in enumerate(tree.links)}
    chain = [link_indices[joint.position_start()] for joint in joints]
    parents = [tree.links[i].parent for i in chain]
    return joints if parents[1:] == chain[:-1] else None
