"""Adjacent links: pairs joined by a joint, and which of them are not checked, by evidence.

Shapes of neighbours often overlap around their joint, by design or because a hull bulges; a check
of such a pair would make every configuration invalid. A pair is left out if its shapes touch at the
joint's default position, or at half of the joint's range or more; and if they are proven never to
touch, at any joint angle. Every other pair is checked like any other
(docs/decisions/0031).

Drake's distances of separate shapes are never too small, but can be too large
(docs/decisions/0006): shapes that touch by Drake do touch, and separation is proven by slabs
of our own.
"""

from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from planning.domain.arrays import Array
from planning.kernel.shape import ConvexShape
from planning.kernel.shape_distance import distance_bounds, slab
from planning.world.collision.drake_distance import distance_of
from planning.world.collision.half_spaces import has_half_space, height, measurable

type Ids = tuple[GeometryId, GeometryId]

_NUM_SAMPLES = 17
_MOST_OVERLAPPING = 0.5
# Distance up to which shapes touch: rounding error of faces that meet without a gap [m].
_FLUSH = 1e-4
# Largest number of measured positions of a revolute joint, to prove that its bodies never touch;
# accuracy of distances [m], and the share of Drake's that a slab may lack.
_MOST_LOOKS, _TRUSTED = 600, 1e-7
_SHOWN = 0.02
# Initial displacement of a point within an interval, as a share of the distance.
_MOST_STRAY = 0.8
# Range of an unlimited joint: a whole turn, or a metre either way.
_UNLIMITED = {"revolute": np.pi, "prismatic": 1.0}


@dataclass(frozen=True)
class Neighbours:
    """Two bodies joined by a joint that are not checked against each other.

    Attributes:
        bodies: Parent and child.
        evidence: Why not, in words.
    """

    bodies: tuple[BodyIndex, BodyIndex]
    evidence: str


def unchecked_neighbours(diagram: Any, plant: MultibodyPlant, scene_graph: Any) -> list[Neighbours]:
    """Return the neighbours that cannot be checked against each other, or need not be.

    Args:
        diagram: Has the plant; its pairs of neighbours are not filtered.
        plant: Finalized.
        scene_graph: Of the diagram.
    """
    pairs = _adjacent_candidates(plant, scene_graph)
    if not pairs:
        return []
    context = diagram.CreateDefaultContext()
    probe = _Probe(plant, scene_graph, context, pairs)
    at_default = probe.touching()
    counts = dict.fromkeys(pairs, 0)
    for share in np.linspace(0.0, 1.0, _NUM_SAMPLES):
        probe.go_to(float(share))
        for joint in probe.touching():
            counts[joint] += 1
    found: list[Neighbours] = []
    for joint, count in counts.items():
        if joint in at_default or count >= _MOST_OVERLAPPING * _NUM_SAMPLES:
            name = plant.get_joint(joint).name()
            where = "where it is by default, and " if joint in at_default else ""
            evidence = (
                f"their shapes touch about joint {name}: {where}at {count} of {_NUM_SAMPLES} "
                "places of its range"
            )
            found.append(Neighbours(_ends(plant, joint), evidence))
        elif count == 0 and (least := probe.least_distance(joint)) > 0:
            name = plant.get_joint(joint).name()
            evidence = f"at least {_floored(least):g} m apart wherever joint {name} turns to"
            found.append(Neighbours(_ends(plant, joint), evidence))
    return found


class _Probe:
    """Contact test of neighbours, with every joint at the same fraction of its own range."""

    def __init__(self, plant: Any, scene_graph: Any, context: Any, pairs: dict[Any, Any]) -> None:
        self._plant, self._pairs, self._inspector = plant, pairs, scene_graph.model_inspector()
        self._plant_context = plant.GetMyMutableContextFromRoot(context)
        self._query_context = scene_graph.GetMyContextFromRoot(context)
        self._port = scene_graph.get_query_output_port()
        self._shapes: dict[GeometryId, ConvexShape] = {}

    def go_to(self, share: float) -> None:
        """Set every joint to a fraction of its range; joints of several coordinates stay."""
        q = self._plant.GetPositions(self._plant_context)
        for index in self._pairs:
            joint = self._plant.get_joint(index)
            reach = _UNLIMITED.get(joint.type_name())
            if reach is None:
                continue
            low = np.maximum(joint.position_lower_limits(), -reach * _is_open(joint))
            high = np.minimum(joint.position_upper_limits(), reach * _is_open(joint))
            q[joint.position_start()] = (low + share * (high - low))[0]
        self._plant.SetPositions(self._plant_context, q)

    def least_distance(self, index: Any) -> float:
        """Return a lower bound on the distance of a joint's bodies over a whole turn [m].

        Zero or less if there is none, or it takes too long to find. By adaptive bisection of the
        joint angle: while the joint turns by a, no point of the child at a distance r from the axis
        moves farther than r a.
        """
        joint = self._plant.get_joint(index)
        if joint.type_name() != "revolute":
            return 0.0
        reach, least = self._reach(joint), np.inf
        first = self._distance_at(joint, 0.0)
        if first <= 0 or not np.isfinite(reach):
            return 0.0
        edges = np.linspace(-np.pi, np.pi, 2 + int(np.pi * reach / (_MOST_STRAY * first)))
        pending = list(pairwise(edges.tolist()))
        for _ in range(_MOST_LOOKS):
            if not pending:
                return float(least)
            low, high = pending.pop()
            distance = self._distance_at(joint, (low + high) / 2)
            stray = reach * (high - low) / 2
            if distance <= 0:
                break
            if stray > 0.95 * distance:
                pending += [(low, (low + high) / 2), ((low + high) / 2, high)]
            else:
                least = min(least, distance - stray)
        return 0.0

    def _distance_at(self, joint: Any, angle: float) -> float:
        """Return a lower bound on the distance of the joint's bodies at one joint angle [m]."""
        joint.set_angle(self._plant_context, angle)
        query = self._port.Eval(self._query_context)
        found = [(pair, self._measured(query, pair)) for pair in self._pairs[joint.index()]]
        least = np.inf
        # The nearest first: for the others a slab of the same width suffices.
        for pair, seen in sorted(found, key=lambda entry: entry[1][0]):
            least = min(least, self._bounds(query, pair, seen, least)[0])
        return float(least) - _TRUSTED

    def _reach(self, joint: Any) -> float:
        """Return an upper bound on the distance of the child's shapes from the joint axis [m]."""
        body = joint.child_body()
        X_MB = joint.frame_on_child().GetFixedPoseInBodyFrame().inverse()
        axis = joint.revolute_axis()
        reach = 0.0
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            box = self._inspector.GetObbInGeometryFrame(geometry)
            if box is None:
                return float(np.inf)
            X_MO = X_MB @ self._inspector.GetPoseInFrame(geometry) @ box.pose()
            corners = np.stack(np.meshgrid(*([[-1.0, 1.0]] * 3)), axis=-1).reshape(-1, 3)
            points = (X_MO.rotation().matrix() @ (corners * box.half_width()).T).T
            points = points + X_MO.translation()
            away = points - np.outer(points @ axis, axis)
            reach = max(reach, float(np.linalg.norm(away, axis=1).max()))
        return reach

    def touching(self) -> set[Any]:
        """Return the joints whose two bodies touch."""
        query = self._port.Eval(self._query_context)
        return {
            joint
            for joint, geometries in self._pairs.items()
            if any(self._touch(query, pair) for pair in geometries)
        }

    def _touch(self, query: Any, pair: Ids) -> bool:
        seen = self._measured(query, pair)
        return seen[0] <= _FLUSH or self._bounds(query, pair, seen, _FLUSH)[1] <= _FLUSH

    def _measured(self, query: Any, pair: Ids) -> tuple[float, Array]:
        """Return a distance that is not too small [m], and a direction from B to A."""
        if has_half_space(self._inspector, pair):
            return height(self._convex(pair), self._poses(query, pair))[0], np.zeros(3)
        found = distance_of(query, *pair)
        return float(found.distance), np.array(found.nhat_BA_W)

    def _bounds(
        self, query: Any, pair: Ids, seen: tuple[float, Array], enough: float
    ) -> tuple[float, float]:
        """Bound the distance of two geometries where they are [m].

        Args:
            query: Drake's, at the plant's present state.
            pair: Both.
            seen: Distance and direction by `_measured`.
            enough: Largest useful lower bound; nearly all of the measured distance suffices too.
        """
        distance, normal = seen
        if distance <= 0 or has_half_space(self._inspector, pair):
            return distance, distance
        shapes, poses = self._convex(pair), self._poses(query, pair)
        enough = min(enough, (1 - _SHOWN) * distance)
        if (shown := slab(shapes, poses, normal)) >= enough:
            return shown, distance
        found = distance_bounds(shapes, poses, normal, enough)
        return found.lower, min(found.upper, distance)

    def _convex(self, pair: Ids) -> tuple[ConvexShape, ConvexShape]:
        for i in pair:
            if i not in self._shapes:
                self._shapes[i] = measurable(self._inspector, i)
        return self._shapes[pair[0]], self._shapes[pair[1]]

    @staticmethod
    def _poses(query: Any, pair: Ids) -> tuple[Array, Array]:
        a, b = (np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in pair)
        return a, b


def _floored(length: float) -> float:
    """Return a positive length rounded down to two digits."""
    unit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(np.floor(length / unit) * unit)


def _is_open(joint: Any) -> Array:
    """Return 1 for unlimited coordinates, infinity for those with limits of their own."""
    low, high = joint.position_lower_limits(), joint.position_upper_limits()
    return np.where(np.isfinite(low) & np.isfinite(high), np.inf, 1.0)


def _ends(plant: MultibodyPlant, joint: Any) -> tuple[BodyIndex, BodyIndex]:
    found = plant.get_joint(joint)
    return found.parent_body().index(), found.child_body().index()


def _adjacent_candidates(plant: MultibodyPlant, scene_graph: Any) -> dict[Any, list[Any]]:
    """Return the checked pairs of geometries, by the joint that joins their bodies."""
    inspector = scene_graph.model_inspector()
    ordered: list[tuple[int, int, Any, Any]] = []
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if not 0 < joint.num_velocities() < 6:
            continue
        ends = [plant.GetCollisionGeometriesForBody(end) for end in _bodies(joint)]
        for pair in product(*ends):
            a, b = sorted(pair)
            if not inspector.CollisionFiltered(a, b):
                ordered.append((a.get_value(), b.get_value(), index, (a, b)))
    found: dict[Any, list[Any]] = {}
    for _, _, index, pair in sorted(ordered, key=lambda entry: entry[:2]):
        found.setdefault(index, []).append(pair)
    return found


def _bodies(joint: Any) -> tuple[Any, Any]:
    return joint.parent_body(), joint.child_body()
