"""DistanceQuery: signed margins of near pairs of bodies along a curve, with gradients by q."""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.kernel.native import native
from planning.refine.constraints.distance_buffers import PairThresholds
from planning.refine.constraints.moving_pairs import group_checker, moved_pairs
from planning.world.collision.half_space_heights import HalfSpaceHeights
from planning.world.collision.half_spaces import half_space_pairs_of
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import KernelScene, kernel_scene_of
from planning.world.world import World


@dataclass(frozen=True)
class DistanceRows:
    """Near pairs, one per row.

    Attributes:
        sample_indices: Index of the configuration, shape (m,).
        signed_margins: Signed margin: distance minus required distance [m], shape (m,).
        gradients: Gradients of the distance with respect to the group's v, shape (m, nv).
    """

    sample_indices: Indices
    signed_margins: Array
    gradients: Array


@runtime_checkable
class DistanceQuery(Protocol):
    """Distances of pairs that the group moves relative to each other."""

    def within(self, qs: Float64[np.ndarray, "m nq"], influence_distance: float) -> DistanceRows:
        """Return the pairs with a signed margin below `influence_distance` [m]."""
        ...


class KernelDistanceQuery:
    """Distance query by the native kernel: all pairs of all configurations in one call."""

    def __init__(
        self,
        scene: KernelScene,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        thresholds: PairThresholds,
    ) -> None:
        """Prepare for a group; other joints are at `state`."""
        module: Any = native()
        self._native = module.DistanceQuery(
            scene.native,
            model.position_indices(group).astype(np.int64),
            model.velocity_indices(group).astype(np.int64),
            model.apply_couplings(np.array(state)),
        )
        self._thresholds = scene.by_pair(thresholds.threshold, thresholds.override_pairs)

    def within(self, qs: Float64[np.ndarray, "m nq"], influence_distance: float) -> DistanceRows:
        """Return the pairs with a signed margin below `influence_distance` [m]."""
        sample_indices, pairs, distances, _, gradients = self._native.within(
            np.ascontiguousarray(qs), self._thresholds + influence_distance
        )
        return DistanceRows(sample_indices, distances - self._thresholds[pairs], gradients)


class DrakeDistanceQuery:
    """Distance query by Drake's collision checker, one configuration after another.

    Pairs with half spaces are computed separately: Drake's checker has no distances for them.
    """

    def __init__(
        self,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        thresholds: PairThresholds,
    ) -> None:
        """Prepare for a group; other joints are at `state`."""
        self._checker = group_checker(model, group, thresholds)
        self._model = model
        self._group = group
        self._state = state
        self._context: Any = model.plant.CreateDefaultContext()
        self._is_flat = Manifold(group.joints).is_flat
        self._velocity_jacobian = self._velocity_to_qdot(np.array(state))
        bodies = half_space_pairs_of(model).bodies
        self._is_height_pair = moved_pairs(model, group, bodies)
        self._thresholds = np.array(
            [thresholds.threshold(*pair) for pair in bodies], dtype=np.float64
        )
        self._heights = HalfSpaceHeights(model) if self._is_height_pair.any() else None

    def within(self, qs: Float64[np.ndarray, "m nq"], influence_distance: float) -> DistanceRows:
        """Return the pairs with a signed margin below `influence_distance` [m]."""
        sample_indices, signed_margins, gradients = [], [], []
        for i, positions in enumerate(self._model.embed(self._group, qs, self._state)):
            clearance: Any = self._checker.CalcRobotClearance(positions, influence_distance)
            velocity_jacobian = (
                self._velocity_jacobian if self._is_flat else self._velocity_to_qdot(positions)
            )
            signed_margins.append(np.array(clearance.distances()))
            gradients.append(np.array(clearance.jacobians()) @ velocity_jacobian)
            heights, height_gradients = self._half_space_rows(positions, influence_distance)
            signed_margins.append(heights)
            gradients.append(height_gradients @ velocity_jacobian)
            sample_indices.append(np.full(clearance.size() + len(heights), i))
        return DistanceRows(
            np.concatenate(sample_indices), np.concatenate(signed_margins), np.vstack(gradients)
        )

    def _half_space_rows(
        self, positions: Float64[np.ndarray, " num_positions"], influence_distance: float
    ) -> tuple[Array, Array]:
        """Return signed margins of heights over half spaces, and their gradients by q."""
        if self._heights is None:
            return np.zeros(0), np.zeros((0, len(positions)))
        rows, heights, gradients = self._heights.heights_within(
            positions, self._thresholds + influence_distance
        )
        is_selected = self._is_height_pair[rows]
        return (heights - self._thresholds[rows])[is_selected], gradients[is_selected]

    def _velocity_to_qdot(self, positions: Float64[np.ndarray, " num_positions"]) -> Array:
        """Return the derivative of the plant's positions by the group's v; gradients are by q."""
        plant = self._model.plant
        plant.SetPositions(self._context, positions)
        velocity_map: Any = plant.MakeVelocityToQDotMap(self._context)
        columns = velocity_map.toarray()[:, self._model.velocity_indices(self._group)]
        for c in self._model.couplings:
            columns[c.follower_position] = c.multiplier * columns[c.leader_position]
        return columns


def make_distance_query(
    world: World, group: JointGroup, thresholds: PairThresholds
) -> DistanceQuery:
    """Return the kernel's distance query, or Drake's where there is no kernel."""
    scene = kernel_scene_of(world.drake)
    if scene is None:
        return DrakeDistanceQuery(world.drake, group, world.state, thresholds)
    return KernelDistanceQuery(scene, world.drake, group, world.state, thresholds)
