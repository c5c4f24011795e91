"""SearchSpace: the OMPL state space of a group, and the way between its states and q.

Joints of one coordinate and limits are a vector; continuous joints are SO(2), planar joints SE(2),
floating joints SE(3); a group that mixes them is a compound. OMPL measures a compound by the sum
of its parts' distances, `Manifold.distance` by the root of their squares: the two agree within the
square root of the number of parts, and exactly for a group of bounded joints. Where a request
weighs joints, OMPL's distances are weighted and ours are not: a vector's state is q times the
weights, other parts are weighted by their compound. A rotation that is held is no part of a state.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

import numpy as np
from jaxtyping import Float64
from ompl import base as ob

from planning.domain.joints import Joint, JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Where a translation has no limits, this is how far from the world's origin is searched [m] ...
_REACH = 10.0
# ... or so far beyond the start and the goals, if they lie outside [m].
_SURROUNDINGS = 1.0
# OMPL wants each range to have a width.
_LEAST_WIDTH = 1e-9

_SE3_FROM_Q = (4, 5, 6, 1, 2, 3, 0)
_SAME = 1e-6


@dataclass(frozen=True)
class _Part:
    """A part of the space.

    Attributes:
        kind: Revolute for a vector of whatever is measured by numbers.
        indices: Into q, of its values, in OMPL's order.
        weights: Of each value of a vector, of a circle, of the shift and the turn of a body.
    """

    kind: JointType
    indices: list[int]
    weights: list[float]


class SearchSpace:
    """A state space with a fixed order of its values.

    Attributes:
        manifold: The same set with our metric.
        ompl: OMPL's state space; it never leaves `planning.search`.
        lower: Search bounds, finite but for circles and quaternions, shape (nq,).
        upper: And above, shape (nq,).
        is_mixed: Whether it is a compound that OMPL has no name for.
        numbers: Returns the q of an OMPL state as a list, which is what OMPL gives.
    """

    def __init__(
        self,
        group: JointGroup,
        limits: JointLimits,
        anchors: Float64[np.ndarray, "m nq"],
        weights: Float64[np.ndarray, " num_blocks"] | None = None,
        held: Sequence[int] = (),
    ) -> None:
        """Build the space.

        Args:
            group: The joints.
            limits: Their position limits.
            anchors: Configurations that must lie inside, the start first, shape (m, nq).
            weights: Of the group's blocks in OMPL's distances; None for 1.
            held: Coordinates of q that stay as they are at the start: whole rotations.
        """
        self.manifold = Manifold(group.joints)
        self.lower, self.upper = _search_bounds(group, limits, anchors)
        self._held = list(held)
        self._rest = anchors[0]
        given = np.ones(len(group.blocks)) if weights is None else weights
        parts = _parts(group, given, self._held)
        # A circle alone becomes a compound as well: `setup` of SO2StateSpace is not bound.
        self.is_mixed = len(parts) > 1 or parts[0].kind is JointType.CONTINUOUS
        self._from_q = [i for part in parts for i in part.indices]
        self._scale = np.array([scale for part in parts for scale in _scales(part)])
        self.ompl = self._assemble(parts)
        self.ompl.setup()
        self._to_q = [int(i) for i in np.argsort(self._from_q)]
        self._angles = [i for i, wraps in zip(self._from_q, _circles(parts), strict=True) if wraps]
        self.numbers = self._reader()

    def read(self, state: Any) -> Array:
        """Return the q of an OMPL state, shape (nq,)."""
        return np.array(self.numbers(state))

    def _reader(self) -> Callable[[Any], list[float]]:
        is_vector = isinstance(self.ompl, ob.RealVectorStateSpace)
        if self._held or (self._scale != 1).any():
            return self._rescaled(is_vector=is_vector)
        return itemgetter(slice(0, len(self._from_q))) if is_vector else self._values

    def _values(self, state: Any) -> list[float]:
        value = self.ompl.getValueAddressAtIndex
        return [value(state, i) for i in self._to_q]

    def _rescaled(self, *, is_vector: bool) -> Callable[[Any], list[float]]:
        """Return a reader of states whose values are scaled, or are not all of q."""
        count = len(self._from_q)
        rest = self._rest.tolist()
        lower, upper = self.lower[self._from_q].tolist(), self.upper[self._from_q].tolist()
        places = list(zip(self._from_q, self._scale.tolist(), lower, upper, strict=True))
        value = self.ompl.getValueAddressAtIndex
        whole = slice(0, count)

        def read(state: Any) -> list[float]:
            values = state[whole] if is_vector else [value(state, i) for i in range(count)]
            q = rest.copy()
            for x, (i, scale, low, high) in zip(values, places, strict=True):
                # Scaled and back, a limit may be off by a rounding error.
                q[i] = min(max(x / scale, low), high)
            return q

        return read

    def write(self, q: Float64[np.ndarray, " nq"]) -> Any:
        """Return a new OMPL state at q, shape (nq,); quaternions are normalised."""
        q = np.clip(self.manifold.normalized(q), self.lower, self.upper)
        q[self._angles] = np.remainder(q[self._angles] + np.pi, 2 * np.pi) - np.pi
        state = self.ompl.allocState()
        self.ompl.copyFromReals(state, (q[self._from_q] * self._scale).tolist())
        return state

    def at_rest(self, qs: Float64[np.ndarray, "m nq"]) -> Array:
        """Return configurations with the held coordinates as they are at the start."""
        resting = qs.copy()
        resting[:, self._held] = self._rest[self._held]
        return resting

    def contains(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether q, shape (nq,), lies in the searched box, with every held rotation."""
        if self._held:
            turned = np.array(q)
            turned[self._held] = self._rest[self._held]
            if float(self.manifold.distance(turned, q)) > _SAME:
                return False
        return bool(((q >= self.lower - 1e-9) & (q <= self.upper + 1e-9)).all())

    def _assemble(self, parts: list[_Part]) -> Any:
        spaces = [self._sub_space(part) for part in parts]
        if not self.is_mixed:
            return spaces[0]
        circle = JointType.CONTINUOUS
        weights = [part.weights[0] if part.kind is circle else 1.0 for part in parts]
        compound = ob.CompoundStateSpace(spaces, weights)
        compound.lock()
        # What KPIECE and its kin spread over: the first part, which has the most to say.
        compound.registerDefaultProjection(ob.SubspaceProjectionEvaluator(compound, 0))
        return compound

    def _sub_space(self, part: _Part) -> Any:
        indices = part.indices
        match part.kind:
            case JointType.CONTINUOUS:
                return ob.SO2StateSpace()
            case JointType.PLANAR:
                space = ob.SE2StateSpace()
                space.setBounds(self._bounds(indices[:2]))
                space.setSubspaceWeight(0, part.weights[0])
                space.setSubspaceWeight(1, part.weights[1])
            case JointType.FLOATING:
                space = ob.SE3StateSpace()
                space.setBounds(self._bounds(indices[:3]))
                # OMPL's distance on SO(3) is half the angle of the rotation.
                space.setSubspaceWeight(0, part.weights[0])
                space.setSubspaceWeight(1, 2.0 * part.weights[1])
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
    """Return finite bounds wherever OMPL needs them."""
    nearest = np.minimum(-_REACH, anchors.min(axis=0) - _SURROUNDINGS)
    furthest = np.maximum(_REACH, anchors.max(axis=0) + _SURROUNDINGS)
    lower = np.where(np.isfinite(limits.lower), limits.lower, nearest)
    upper = np.where(np.isfinite(limits.upper), limits.upper, furthest)
    free = _unbounded(group)
    lower[free], upper[free] = -np.inf, np.inf
    return lower, np.maximum(upper, lower + _LEAST_WIDTH)


def _unbounded(group: JointGroup) -> list[int]:
    """Return the coordinates of q that have no bounds in OMPL: circles and quaternions."""
    found: list[int] = []
    iq = 0
    for joint in group.joints:
        match joint.type:
            case JointType.CONTINUOUS:
                found.append(iq)
            case JointType.PLANAR:
                found.append(iq + 2)
            case JointType.FLOATING:
                found += range(iq, iq + 4)
            case _:
                pass
        iq += joint.num_positions
    return found


def _parts(
    group: JointGroup, weights: Float64[np.ndarray, " num_blocks"], held: Sequence[int]
) -> list[_Part]:
    """Return each part; a body whose rotation is held is three, or two, numbers of the vector."""
    vector, others = _Part(JointType.REVOLUTE, [], []), list[_Part]()
    iq = 0
    remaining = iter(weights.tolist())
    for joint in group.joints:
        own = {name: next(remaining) for name, _ in joint.blocks}
        indices = _value_order(joint, iq)
        shift = own.get(f"{joint.name}.linear", 1.0)
        if joint.type in {JointType.REVOLUTE, JointType.PRISMATIC}:
            vector.indices.append(iq)
            vector.weights.append(own[joint.name])
        elif not set(indices).isdisjoint(held):
            moving = [i for i in indices if i not in held]
            vector.indices.extend(moving)
            vector.weights.extend([shift] * len(moving))
        else:
            turn = own.get(f"{joint.name}.angular", 1.0)
            is_circle = joint.type is JointType.CONTINUOUS
            others.append(
                _Part(joint.type, indices, [own[joint.name]] if is_circle else [shift, turn])
            )
        iq += joint.num_positions
    return ([vector] if vector.indices else []) + others


def _value_order(joint: Joint, iq: int) -> list[int]:
    if joint.type is JointType.FLOATING:
        return [iq + k for k in _SE3_FROM_Q]
    return list(range(iq, iq + joint.num_positions))


def _scales(part: _Part) -> list[float]:
    is_vector = part.kind is JointType.REVOLUTE
    return part.weights if is_vector else [1.0] * len(part.indices)


def _circles(parts: list[_Part]) -> list[bool]:
    flags: list[bool] = []
    for part in parts:
        wraps = {JointType.CONTINUOUS: [True], JointType.PLANAR: [False, False, True]}
        flags += wraps.get(part.kind, [False] * len(part.indices))
    return flags
