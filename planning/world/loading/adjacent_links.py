"""Adjacent links: pairs joined by a joint, and which of them are not checked, by evidence.

Shapes of neighbours often overlap around their joint, by design or because a hull bulges; a check
of such a pair would make every configuration invalid. A pair is left out if its shapes touch at the
joint's default position, or at half of the joint's range or more; and if they are proven never to
touch, at any joint angle. Every other pair is checked like any other (docs/decisions/0031).

Drake's distances of separate shapes are never too small, but can be too large
(docs/decisions/0006): shapes that touch by Drake do touch, and separation is proven by slabs of our
own.
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
from planning.kernel.shape_distance import distance_bounds, slab_width
from planning.world.collision.drake_distance import pair_distance
from planning.world.collision.half_spaces import has_half_space, height, resolve_convex_shape

type Ids = tuple[GeometryId, GeometryId]

_NUM_SAMPLES = 17
_MAX_TOUCHING_FRACTION = 0.5
# Distance up to which shapes touch: rounding error of faces that meet without a gap [m].
_TOUCH_DISTANCE = 1e-4
# Largest number of measured positions of a revolute joint, to prove that its bodies never touch;
# accuracy of distances [m], and the share of Drake's that a slab may lack.
_MAX_QUERIES, _DISTANCE_ACCURACY = 600, 1e-7
_SLAB_TOLERANCE = 0.02
# Initial displacement of a point within an interval, as a share of the distance.
_MAX_DISPLACEMENT_RATIO = 0.8
# Range of an unlimited joint: a whole turn, or a metre either way.
_UNLIMITED_RANGE = {"revolute": np.pi, "prismatic": 1.0}


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
    probe = _AdjacentPairProbe(plant, scene_graph, context, pairs)
    touching_by_default = probe.touching_joints()
    counts = dict.fromkeys(pairs, 0)
    for fraction in np.linspace(0.0, 1.0, _NUM_SAMPLES):
        probe.set_range_fraction(float(fraction))
        for joint in probe.touching_joints():
            counts[joint] += 1
    found: list[Neighbours] = []
    for joint, count in counts.items():
        if joint in touching_by_default or count >= _MAX_TOUCHING_FRACTION * _NUM_SAMPLES:
            name = plant.get_joint(joint).name()
            where = "where it is by default, and " if joint in touching_by_default else ""
            evidence = (
                f"their shapes touch about joint {name}: {where}at {count} of {_NUM_SAMPLES} "
                "places of its range"
            )
            found.append(Neighbours(_joint_bodies(plant, joint), evidence))
        elif count == 0 and (distance_bound := probe.distance_lower_bound(joint)) > 0:
            name = plant.get_joint(joint).name()
            evidence = (
                f"at least {_rounded_down(distance_bound):g} m apart wherever joint {name} turns to"
            )
            found.append(Neighbours(_joint_bodies(plant, joint), evidence))
    return found


class _AdjacentPairProbe:
    """Contact test of neighbours, with every joint at the same fraction of its own range."""

    def __init__(self, plant: Any, scene_graph: Any, context: Any, pairs: dict[Any, Any]) -> None:
        self._plant, self._pairs, self._inspector = plant, pairs, scene_graph.model_inspector()
        self._plant_context = plant.GetMyMutableContextFromRoot(context)
        self._query_context = scene_graph.GetMyContextFromRoot(context)
        self._port = scene_graph.get_query_output_port()
        self._shapes: dict[GeometryId, ConvexShape] = {}

    def set_range_fraction(self, fraction: float) -> None:
        """Set every joint to a fraction of its range; joints of several coordinates stay."""
        q = self._plant.GetPositions(self._plant_context)
        for index in self._pairs:
            joint = self._plant.get_joint(index)
            half_range = _UNLIMITED_RANGE.get(joint.type_name())
            if half_range is None:
                continue
            low = np.maximum(joint.position_lower_limits(), -half_range * _range_factors(joint))
            high = np.minimum(joint.position_upper_limits(), half_range * _range_factors(joint))
            q[joint.position_start()] = (low + fraction * (high - low))[0]
        self._plant.SetPositions(self._plant_context, q)

    def distance_lower_bound(self, index: Any) -> float:
        """Return a lower bound on the distance of a joint's bodies over a whole turn [m].

        Zero or less if there is none, or it takes too long to find. By adaptive bisection of the
        joint angle: while the joint turns by a, no point of the child at a distance r from the axis
        moves farther than r a.
        """
        joint = self._plant.get_joint(index)
        if joint.type_name() != "revolute":
            return 0.0
        radius, lower_bound = self._radius_about_axis(joint), np.inf
        first = self._distance_at(joint, 0.0)
        if first <= 0 or not np.isfinite(radius):
            return 0.0
        edges = np.linspace(
            -np.pi, np.pi, 2 + int(np.pi * radius / (_MAX_DISPLACEMENT_RATIO * first))
        )
        pending = list(pairwise(edges.tolist()))
        for _ in range(_MAX_QUERIES):
            if not pending:
                return float(lower_bound)
            low, high = pending.pop()
            distance = self._distance_at(joint, (low + high) / 2)
            max_displacement = radius * (high - low) / 2
            if distance <= 0:
                break
            if max_displacement > 0.95 * distance:
                pending += [(low, (low + high) / 2), ((low + high) / 2, high)]
            else:
                lower_bound = min(lower_bound, distance - max_displacement)
        return 0.0

    def _distance_at(self, joint: Any, angle: float) -> float:
        """Return a lower bound on the distance of the joint's bodies at one joint angle [m]."""
        joint.set_angle(self._plant_context, angle)
        query = self._port.Eval(self._query_context)
        measured = [(pair, self._measure(query, pair)) for pair in self._pairs[joint.index()]]
        lower_bound = np.inf
        # The nearest first: for the others a slab of the same width suffices.
        for pair, measurement in sorted(measured, key=lambda entry: entry[1][0]):
            lower_bound = min(lower_bound, self._bounds(query, pair, measurement, lower_bound)[0])
        return float(lower_bound) - _DISTANCE_ACCURACY

    def _radius_about_axis(self, joint: Any) -> float:
        """Return an upper bound on the distance of the child's shapes from the joint axis [m]."""
        body = joint.child_body()
        X_MB = joint.frame_on_child().GetFixedPoseInBodyFrame().inverse()
        axis = joint.revolute_axis()
        radius = 0.0
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            box = self._inspector.GetObbInGeometryFrame(geometry)
            if box is None:
                return float(np.inf)
            X_MO = X_MB @ self._inspector.GetPoseInFrame(geometry) @ box.pose()
            corners = np.stack(np.meshgrid(*([[-1.0, 1.0]] * 3)), axis=-1).reshape(-1, 3)
            points = (X_MO.rotation().matrix() @ (corners * box.half_width()).T).T
            points = points + X_MO.translation()
            offsets = points - np.outer(points @ axis, axis)
            radius = max(radius, float(np.linalg.norm(offsets, axis=1).max()))
        return radius

    def touching_joints(self) -> set[Any]:
        """Return the joints whose two bodies touch."""
        query = self._port.Eval(self._query_context)
        return {
            joint
            for joint, geometries in self._pairs.items()
            if any(self._are_touching(query, pair) for pair in geometries)
        }

    def _are_touching(self, query: Any, pair: Ids) -> bool:
        measurement = self._measure(query, pair)
        return (
            measurement[0] <= _TOUCH_DISTANCE
            or self._bounds(query, pair, measurement, _TOUCH_DISTANCE)[1] <= _TOUCH_DISTANCE
        )

    def _measure(self, query: Any, pair: Ids) -> tuple[float, Array]:
        """Return a distance that is not too small [m], and a direction from B to A."""
        if has_half_space(self._inspector, pair):
            return height(self._convex_shapes(pair), self._poses(query, pair))[0], np.zeros(3)
        found = pair_distance(query, *pair)
        return float(found.distance), np.array(found.nhat_BA_W)

    def _bounds(
        self, query: Any, pair: Ids, measurement: tuple[float, Array], sufficient_distance: float
    ) -> tuple[float, float]:
        """Bound the distance of two geometries where they are [m].

        Args:
            query: Drake's, at the plant's present state.
            pair: Both.
            measurement: Distance and direction by `_measure`.
            sufficient_distance: Largest useful lower bound; nearly all of the measured distance
                suffices too.
        """
        distance, normal = measurement
        if distance <= 0 or has_half_space(self._inspector, pair):
            return distance, distance
        shapes, poses = self._convex_shapes(pair), self._poses(query, pair)
        sufficient_distance = min(sufficient_distance, (1 - _SLAB_TOLERANCE) * distance)
        if (width := slab_width(shapes, poses, normal)) >= sufficient_distance:
            return width, distance
        found = distance_bounds(shapes, poses, normal, sufficient_distance)
        return found.lower, min(found.upper, distance)

    def _convex_shapes(self, pair: Ids) -> tuple[ConvexShape, ConvexShape]:
        for i in pair:
            if i not in self._shapes:
                self._shapes[i] = resolve_convex_shape(self._inspector, i)
        return self._shapes[pair[0]], self._shapes[pair[1]]

    @staticmethod
    def _poses(query: Any, pair: Ids) -> tuple[Array, Array]:
        a, b = (np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in pair)
        return a, b


def _rounded_down(length: float) -> float:
    """Return a positive length rounded down to two digits."""
    unit = 10.0 ** (np.floor(np.log10(length)) - 1)
    return float(np.floor(length / unit) * unit)


def _range_factors(joint: Any) -> Array:
    """Return 1 for unlimited coordinates, infinity for those with limits of their own."""
    low, high = joint.position_lower_limits(), joint.position_upper_limits()
    return np.where(np.isfinite(low) & np.isfinite(high), np.inf, 1.0)


def _joint_bodies(plant: MultibodyPlant, joint: Any) -> tuple[BodyIndex, BodyIndex]:
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
