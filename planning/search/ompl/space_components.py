"""SpaceComponent: part of a group's compound state space: a vector, a circle or a body's pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.robot.joints import Joint, JointGroup, JointType
from planning.domain.robot.steering import steering_of

_SE3_FROM_Q = (4, 5, 6, 1, 2, 3, 0)


@dataclass(frozen=True)
class SpaceComponent:
    """Component of the state space.

    Attributes:
        kind: Joint type; REVOLUTE stands for the vector of all scalar coordinates.
        indices: Indices into q of its values, in OMPL's order.
        weights: Weights of the values of a vector; the weight of a circle; or the weights of the
            translation and the rotation of a body.
        turning_radius: Turning radius of a car [m]; 0 for all others.
    """

    kind: JointType
    indices: list[int]
    weights: list[float]
    turning_radius: float = 0.0

    @property
    def weight(self) -> float:
        """Weight of its distances in the compound; most components weight their values instead."""
        is_single_weight = self.turning_radius > 0 or self.kind is JointType.CONTINUOUS
        return self.weights[0] if is_single_weight else 1.0


def space_components(
    group: JointGroup, weights: Float64[np.ndarray, " num_blocks"], held_indices: Sequence[int]
) -> list[SpaceComponent]:
    """Return the components; a body with a held rotation adds its free numbers to the vector."""
    vector, others = SpaceComponent(JointType.REVOLUTE, [], []), list[SpaceComponent]()
    iq = 0
    remaining = iter(weights.tolist())
    for joint in group.joints:
        block_weights = {name: next(remaining) for name, _ in joint.blocks}
        indices = _value_order(joint, iq)
        linear_weight = block_weights.get(f"{joint.name}.linear", 1.0)
        if joint.type in {JointType.REVOLUTE, JointType.PRISMATIC}:
            vector.indices.append(iq)
            vector.weights.append(block_weights[joint.name])
        elif not set(indices).isdisjoint(held_indices):
            moving = [i for i in indices if i not in held_indices]
            vector.indices.extend(moving)
            vector.weights.extend([linear_weight] * len(moving))
        else:
            angular_weight = block_weights.get(f"{joint.name}.angular", 1.0)
            is_circle = joint.type is JointType.CONTINUOUS
            component_weights = (
                [block_weights[joint.name]] if is_circle else [linear_weight, angular_weight]
            )
            steering = steering_of(group).get(joint.name)
            others.append(
                SpaceComponent(
                    joint.type,
                    indices,
                    component_weights,
                    0.0 if steering is None else steering.turning_radius,
                )
            )
        iq += joint.num_positions
    return ([vector] if vector.indices else []) + others


def _value_order(joint: Joint, iq: int) -> list[int]:
    if joint.type is JointType.FLOATING:
        return [iq + k for k in _SE3_FROM_Q]
    return list(range(iq, iq + joint.num_positions))


def value_scales(component: SpaceComponent) -> list[float]:
    """Return the factors between q and a component's values in OMPL's state."""
    is_vector = component.kind is JointType.REVOLUTE
    return component.weights if is_vector else [1.0] * len(component.indices)


def are_angles(components: list[SpaceComponent]) -> list[bool]:
    """Return which values of the space are angles on a circle."""
    flags: list[bool] = []
    for part in components:
        wraps = {JointType.CONTINUOUS: [True], JointType.PLANAR: [False, False, True]}
        flags += wraps.get(part.kind, [False] * len(part.indices))
    return flags
