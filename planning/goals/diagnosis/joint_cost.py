"""Joint cost: quadratic joint-space distance to a goal configuration, as a cost in Drake."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointType
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.nearest_program import AddCost
from planning.goals.ik.group_program import GroupProgram
from planning.goals.joint_metric import JointMetric
from planning.world.world import World


def joint_distance_cost(
    world: World, group: JointGroup, metric: JointMetric, goal: Float64[np.ndarray, " nq"]
) -> AddCost:
    """Return a cost on a program: the squared weighted joint distance to a goal configuration.

    Full turns of continuous joints do not count. The angle of a small rotation is twice the
    distance of the quaternions, so these get twice the mean of the rotation weights. That is an
    approximation of the metric; callers measure the solution in the metric itself.
    """
    manifold = Manifold(group.joints)
    weights = np.ones(manifold.num_velocities) if metric.weights is None else metric.weights
    position_weights = _position_weights(group, weights)

    def add_cost(program: GroupProgram, q: Array) -> None:
        is_flat = manifold.is_flat
        desired = q + manifold.minus(goal, q) if is_flat else _align_quaternions(group, goal, q)
        variables = program.ik.q()[world.drake.position_indices(group)]
        program.ik.get_mutable_prog().AddQuadraticErrorCost(
            np.diag(position_weights**2), desired, variables
        )

    return add_cost


def _position_weights(group: JointGroup, weights: Array) -> Array:
    position_weights, offset = list[float](), 0
    for joint in group.joints:
        joint_weights = weights[offset : offset + joint.num_velocities]
        if joint.type is JointType.FLOATING:
            position_weights += [2 * float(joint_weights[:3].mean())] * 4
            position_weights += joint_weights[3:].tolist()
        else:
            position_weights += joint_weights.tolist()
        offset += joint.num_velocities
    return np.array(position_weights)


def _align_quaternions(group: JointGroup, goal: Array, q: Array) -> Array:
    """Return the goal with quaternions in the hemisphere of q's; both signs mean one rotation."""
    desired, offset = np.array(goal), 0
    for joint in group.joints:
        part = slice(offset, offset + 4)
        if joint.type is JointType.FLOATING and goal[part] @ q[part] < 0:
            desired[part] *= -1
        offset += joint.num_positions
    return desired
