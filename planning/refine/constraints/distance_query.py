"""DistanceQuery: signed margins of near pairs of bodies along a curve, with gradients by q."""

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

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

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True)
class DistanceRows:
    """Near pairs, one per row.

    Attributes:
        at: Index of the configuration, shape (m,).
        spare: Signed margin: distance minus required distance [m], shape (m,).
        gradient: Of the distance with respect to the group's v, shape (m, nv).
    """

    at: Indices
    spare: Array
    gradient: Array


@runtime_checkable
class DistanceQuery(Protocol):
    """Distances of pairs that the group moves relative to each other."""

    def within(self, qs: Float64[np.ndarray, "m nq"], reach: float) -> DistanceRows:
        """Return the pairs with a signed margin below `reach` [m]."""
        ...


class KernelNearness:
    """Distance query by the native kernel: all pairs of all configurations in one call."""

    def __init__(
        self,
        scene: KernelScene,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        demands: PairThresholds,
    ) -> None:
        """Prepare for a group; other joints are at `state`."""
        module: Any = native()
        self._native = module.DistanceQuery(
            scene.native,
            model.position_indices(group).astype(np.int64),
            model.velocity_indices(group).astype(np.int64),
            model.follow(np.array(state)),
        )
        self._demanded = scene.by_pair(demands.demanded, demands.exceptions)

    def within(self, qs: Float64[np.ndarray, "m nq"], reach: float) -> DistanceRows:
        """Return the pairs with a signed margin below `reach` [m]."""
        at, pairs, distances, _, gradients = self._native.within(
            np.ascontiguousarray(qs), self._demanded + reach
        )
        return DistanceRows(at, distances - self._demanded[pairs], gradients)


class DrakeNearness:
    """Distance query by Drake's collision checker, one configuration after another.

    Pairs with half spaces are computed separately: Drake's checker has no distances for them.
    """

    def __init__(
        self,
        model: DrakeModel,
        group: JointGroup,
        state: Float64[np.ndarray, " num_positions"],
        demands: PairThresholds,
    ) -> None:
        """Prepare for a group; other joints are at `state`."""
        self._checker = group_checker(model, group, demands)
        self._model = model
        self._group = group
        self._state = state
        self._context: Any = model.plant.CreateDefaultContext()
        self._is_flat = Manifold(group.joints).is_flat
        self._moved = self._rates(np.array(state))
        bodies = half_space_pairs_of(model).bodies
        self._is_raised = moved_pairs(model, group, bodies)
        self._demanded = np.array([demands.demanded(*pair) for pair in bodies], dtype=np.float64)
        self._heights = HalfSpaceHeights(model) if self._is_raised.any() else None

    def within(self, qs: Float64[np.ndarray, "m nq"], reach: float) -> DistanceRows:
        """Return the pairs with a signed margin below `reach` [m]."""
        at, spare, gradients = [], [], []
        for i, full in enumerate(self._model.embed(self._group, qs, self._state)):
            clearance: Any = self._checker.CalcRobotClearance(full, reach)
            moved = self._moved if self._is_flat else self._rates(full)
            spare.append(np.array(clearance.distances()))
            gradients.append(np.array(clearance.jacobians()) @ moved)
            heights, slopes = self._above(full, reach)
            spare.append(heights)
            gradients.append(slopes @ moved)
            at.append(np.full(clearance.size() + len(heights), i))
        return DistanceRows(np.concatenate(at), np.concatenate(spare), np.vstack(gradients))

    def _above(
        self, full: Float64[np.ndarray, " num_positions"], reach: float
    ) -> tuple[Array, Array]:
        """Return signed margins of heights over half spaces, and their gradients by q."""
        if self._heights is None:
            return np.zeros(0), np.zeros((0, len(full)))
        rows, heights, slopes = self._heights.at(full, self._demanded + reach)
        kept = self._is_raised[rows]
        return (heights - self._demanded[rows])[kept], slopes[kept]

    def _rates(self, full: Float64[np.ndarray, " num_positions"]) -> Array:
        """Return the derivative of the plant's positions by the group's v; gradients are by q."""
        plant = self._model.plant
        plant.SetPositions(self._context, full)
        rates: Any = plant.MakeVelocityToQDotMap(self._context)
        moved = rates.toarray()[:, self._model.velocity_indices(self._group)]
        for c in self._model.couplings:
            moved[c.follower_position] = c.multiplier * moved[c.leader_position]
        return moved


def nearness_of(world: World, group: JointGroup, demands: PairThresholds) -> DistanceQuery:
    """Return the kernel's distance query, or Drake's where there is no kernel."""
    scene = kernel_scene_of(world.drake)
    if scene is None:
        return DrakeNearness(world.drake, group, world.state, demands)
    return KernelNearness(scene, world.drake, group, world.state, demands)
