"""SearchSpace: the OMPL state space of a group, and the conversion between its states and q.

Joints of one coordinate and limits form a vector; continuous joints are SO(2), planar joints SE(2),
or a Reeds-Shepp space if they are steered, floating joints SE(3); a group that mixes them is a
compound. OMPL's distance in a compound is the sum of its parts' distances, `Manifold.distance` the
root of the sum of their squares: the two agree within the square root of the number of parts, and
exactly for a group of bounded joints. Where a request weighs joints, OMPL's distances are weighted
and ours are not: a vector's state is q times the weights, other parts are weighted by their
compound. A held rotation is no part of a state.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from operator import itemgetter
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64
from ompl import base as ob

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.steering import manifold_of
from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.ompl.space_components import (
    SpaceComponent,
    are_angles,
    space_components,
    value_scales,
)

# Search bounds of translations without limits: distance from the world's origin [m] ...
_DEFAULT_BOUND = 10.0
# ... or distance beyond the start and the goals, if these lie outside [m].
_ANCHOR_MARGIN = 1.0
# OMPL requires each range to have a width.
_MIN_WIDTH = 1e-9

# Largest distance of a goal from the start's rotations, where these are fixed [rad].
_ROTATION_TOLERANCE = 1e-6


class SearchSpace:
    """State space with a fixed order of its values.

    Attributes:
        manifold: The same set with our metric.
        lower: Lower search bounds, finite but for circles and quaternions, shape (nq,).
        upper: Upper search bounds, likewise, shape (nq,).
        is_box: Whether OMPL's states are q itself, in a box of real numbers.
    """

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        anchors: Float64[np.ndarray, "m nq"],
        weights: Float64[np.ndarray, " num_blocks"] | None = None,
        held_indices: Sequence[int] = (),
    ) -> None:
        """Build the space.

        Args:
            group: The joints.
            limits: Their position limits.
            anchors: Configurations that must lie inside, the start first, shape (m, nq).
            weights: Weights of the group's blocks in OMPL's distances; None for 1.
            held_indices: Coordinates of q that stay as they are at the start: whole rotations.
        """
        self.manifold = manifold_of(group)
        self.lower, self.upper = _search_bounds(group, limits, anchors)
        self._held_indices = list(held_indices)
        self._start = anchors[0]
        self._group = group
        self._block_weights = np.ones(len(group.blocks)) if weights is None else weights
        self.is_box = (
            group.has_scalar_joints
            and not self._held_indices
            and bool((self._block_weights == 1).all())
        )

    @cached_property
    def _components(self) -> list[SpaceComponent]:
        return space_components(self._group, self._block_weights, self._held_indices)

    @cached_property
    def is_mixed(self) -> bool:
        """Whether it is a compound for which OMPL has no class."""
        components = self._components
        # A single circle becomes a compound as well: `setup` of SO2StateSpace is not bound.
        is_single_circle = components[0].kind is JointType.CONTINUOUS
        return len(components) > 1 or is_single_circle or components[0].weight != 1

    @cached_property
    def _from_q(self) -> list[int]:
        return [i for part in self._components for i in part.indices]

    @cached_property
    def _to_q(self) -> list[int]:
        return [int(i) for i in np.argsort(self._from_q)]

    @cached_property
    def _scale(self) -> Array:
        return np.array([scale for part in self._components for scale in value_scales(part)])

    @cached_property
    def _angles(self) -> list[int]:
        values = zip(self._from_q, are_angles(self._components), strict=True)
        return [i for i, wraps in values if wraps]

    @cached_property
    def ompl(self) -> Any:
        """OMPL's state space, made when it is first needed; it never leaves `planning.search`."""
        return self._make_ompl()

    def _make_ompl(self) -> Any:
        space = self._make_ompl_space(self._components)
        space.setup()
        return space

    @cached_property
    def read_list(self) -> Callable[[Any], list[float]]:
        """Function that returns the q of an OMPL state as a list, OMPL's own type."""
        return self._make_reader()

    def read(self, state: Any) -> Array:
        """Return the q of an OMPL state, shape (nq,)."""
        return np.array(self.read_list(state))

    def _make_reader(self) -> Callable[[Any], list[float]]:
        is_vector = isinstance(self.ompl, ob.RealVectorStateSpace)
        if self._held_indices or (self._scale != 1).any():
            return self._make_scaled_reader(is_vector=is_vector)
        return itemgetter(slice(0, len(self._from_q))) if is_vector else self._read_values

    def _read_values(self, state: Any) -> list[float]:
        value = self.ompl.getValueAddressAtIndex
        return [value(state, i) for i in self._to_q]

    def _make_scaled_reader(self, *, is_vector: bool) -> Callable[[Any], list[float]]:
        """Return a reader of states whose values are scaled or do not cover all of q."""
        count = len(self._from_q)
        start = self._start.tolist()
        lower, upper = self.lower[self._from_q].tolist(), self.upper[self._from_q].tolist()
        coordinates = list(zip(self._from_q, self._scale.tolist(), lower, upper, strict=True))
        value = self.ompl.getValueAddressAtIndex
        whole = slice(0, count)

        def read(state: Any) -> list[float]:
            values = state[whole] if is_vector else [value(state, i) for i in range(count)]
            q = start.copy()
            for x, (i, scale, low, high) in zip(values, coordinates, strict=True):
                # Scaling and its inverse may move a limit by a rounding error.
                q[i] = min(max(x / scale, low), high)
            return q

        return read

    def write(self, q: Float64[np.ndarray, " nq"]) -> Any:
        """Return a new OMPL state at q, shape (nq,); quaternions are normalized."""
        q = self.bounded(q)
        q[self._angles] = np.remainder(q[self._angles] + np.pi, 2 * np.pi) - np.pi
        state = self.ompl.allocState()
        self.ompl.copyFromReals(state, (q[self._from_q] * self._scale).tolist())
        return state

    def bounded(self, q: Float64[np.ndarray, "*n nq"]) -> Array:
        """Return configurations clipped to the search bounds, shape (..., nq)."""
        return np.minimum(np.maximum(self.manifold.normalized(q), self.lower), self.upper)

    def with_held_values(self, qs: Float64[np.ndarray, "m nq"]) -> Array:
        """Return configurations, shape (m, nq), with held coordinates at their start values."""
        configurations = qs.copy()
        configurations[:, self._held_indices] = self._start[self._held_indices]
        return configurations

    def checker(
        self, oracle: WatchedOracle, resolution: float, norm: Callable[[Array], Array] | None
    ) -> EdgeChecker:
        """Return a checker of edges between configurations at a resolution."""
        return EdgeChecker(self.manifold, oracle, resolution, norm)

    def contains(self, qs: Float64[np.ndarray, "n nq"]) -> Bool[np.ndarray, " n"]:
        """Return whether each row is inside the search bounds, with all held rotations."""
        are_inside = ((qs >= self.lower - 1e-9) & (qs <= self.upper + 1e-9)).all(axis=1)
        if self._held_indices:
            distances = self.manifold.distance(self.with_held_values(qs), qs)
            are_inside &= distances <= _ROTATION_TOLERANCE
        return are_inside

    def _make_ompl_space(self, components: list[SpaceComponent]) -> Any:
        spaces = [self._make_subspace(part) for part in components]
        if not self.is_mixed:
            return spaces[0]
        compound = ob.CompoundStateSpace(spaces, [part.weight for part in components])
        compound.lock()
        # Projection for KPIECE and similar planners: the first part, which usually matters most.
        compound.registerDefaultProjection(ob.SubspaceProjectionEvaluator(compound, 0))
        return compound

    def _make_subspace(self, component: SpaceComponent) -> Any:
        indices = component.indices
        match component.kind:
            case JointType.CONTINUOUS:
                return ob.SO2StateSpace()
            case JointType.PLANAR if component.turning_radius > 0:
                space = ob.ReedsSheppStateSpace(component.turning_radius)
                space.setBounds(self._bounds(indices[:2]))
            case JointType.PLANAR:
                space = ob.SE2StateSpace()
                space.setBounds(self._bounds(indices[:2]))
                space.setSubspaceWeight(0, component.weights[0])
                space.setSubspaceWeight(1, component.weights[1])
            case JointType.FLOATING:
                space = ob.SE3StateSpace()
                space.setBounds(self._bounds(indices[:3]))
                # OMPL's distance on SO(3) is half the angle of the rotation.
                space.setSubspaceWeight(0, component.weights[0])
                space.setSubspaceWeight(1, 2.0 * component.weights[1])
            case _:
                space = ob.RealVectorStateSpace(len(indices))
                space.setBounds(self._bounds(indices))
        return space

    def _bounds(self, indices: list[int]) -> Any:
        bounds = ob.RealVectorBounds(len(indices))
        for i, k in enumerate(indices):
            scale = float(self._scale[self._from_q.index(k)])
            bounds.setLow(i, float(self.lower[k]) * scale)
            bounds.setHigh(i, float(self.upper[k]) * scale)
        return bounds


def _search_bounds(group: JointGroup, limits: JointLimits, anchors: Array) -> tuple[Array, Array]:
    """Return position bounds, finite wherever OMPL requires that."""
    if (
        group.has_scalar_joints
        and np.isfinite(limits.lower).all() & np.isfinite(limits.upper).all()
    ):
        return limits.lower, np.maximum(limits.upper, limits.lower + _MIN_WIDTH)
    default_lower = np.minimum(-_DEFAULT_BOUND, anchors.min(axis=0) - _ANCHOR_MARGIN)
    default_upper = np.maximum(_DEFAULT_BOUND, anchors.max(axis=0) + _ANCHOR_MARGIN)
    lower = np.where(np.isfinite(limits.lower), limits.lower, default_lower)
    upper = np.where(np.isfinite(limits.upper), limits.upper, default_upper)
    unbounded = _unbounded_coordinates(group)
    lower[unbounded], upper[unbounded] = -np.inf, np.inf
    return lower, np.maximum(upper, lower + _MIN_WIDTH)


def _unbounded_coordinates(group: JointGroup) -> list[int]:
    """Return the coordinates of q that have no bounds in OMPL: circles and quaternions."""
    indices: list[int] = []
    iq = 0
    for joint in group.joints:
        match joint.type:
            case JointType.CONTINUOUS:
                indices.append(iq)
            case JointType.PLANAR:
                indices.append(iq + 2)
            case JointType.FLOATING:
                indices += range(iq, iq + 4)
            case _:
                pass
        iq += joint.num_positions
    return indices
