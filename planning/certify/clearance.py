"""Clearance on the whole interval, by conservative advancement.

On [t0, t1] the distance of two bodies at the middle instant, less how far their points can move
until either end, bounds their distance from below (see `motion_bounds`). Where the bound is above
the margin the interval is proven; elsewhere it is halved. Distances are Drake's, exact for convex
shapes to the tolerance of its solver.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from planning.certify import bernstein
from planning.certify.motion_bounds import MotionBounds
from planning.certify.request import CertifyRequest
from planning.domain.certificate import Check
from planning.domain.deadline import Deadline
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# Distances that Drake reports are trusted to this much [m].
_SOLVER_TOLERANCE = 1e-7
# A start that keeps its margin exactly would otherwise be refused for rounding [m].
_MARGIN_SLACK = 1e-6
# Intervals shorter than this are given up as unproven [s].
_SHORTEST = 1e-7
_NARROW = 6
_DEADLINE_EVERY = 32
_RESOLUTION = 1e-3
_RELATIVE_RESOLUTION = 0.05
_TIGHTEN_QUERIES = 400
_HORIZONS = (0.05, 0.2, 1.0, 5.0)


@dataclass(frozen=True)
class Clearance:
    """What was found of the clearance.

    Attributes:
        check: The verdict.
        min_clearance: Smallest signed distance at any instant looked at [m].
        pair: Between whom.
        time: When [s].
        intervals: Intervals that were bounded.
        queries: Configurations at which distances were measured.
    """

    check: Check
    min_clearance: float
    pair: tuple[str, str]
    time: float
    intervals: int
    queries: int


@dataclass
class _Node:
    """An interval of one piece.

    Attributes:
        piece: Which.
        t0: Where it begins [s].
        width: How long it is [s].
        bernstein: The tangent's coefficients on it, shape (degree + 1, nv).
        pairs: Indices of pairs that are not decided yet; None for all.
        floor: Lower bound on the distance of the pairs that are decided [m].
    """

    piece: int
    t0: float
    width: float
    bernstein: Array
    pairs: Indices | None
    floor: float


@dataclass
class _Nearest:
    """The smallest distances seen so far."""

    distance: float = np.inf
    pair: tuple[str, str] = ("", "")
    time: float = 0.0
    slack: float = np.inf
    slack_distance: float = np.inf
    slack_margin: float = 0.0
    slack_pair: tuple[str, str] = ("", "")
    slack_time: float = 0.0


@dataclass
class _Counts:
    intervals: int = 0
    queries: int = 0
    leaves: list[_Node] = field(default_factory=list)


def check_clearance(model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> Clearance:
    """Prove, or fail to prove, that every pair of bodies keeps its margin throughout.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: Somebody asked for the end.
    """
    return _Prover(model, request, deadline).run()


class _Prover:
    """One proof in a context of its own."""

    def __init__(self, model: DrakeModel, request: CertifyRequest, deadline: Deadline) -> None:
        self._model = model
        self._request = request
        self._deadline = deadline
        self._context = model.diagram.CreateDefaultContext()
        self._plant_context = model.plant.GetMyMutableContextFromRoot(self._context)
        self._query_context = model.scene_graph.GetMyContextFromRoot(self._context)
        self._port = model.scene_graph.get_query_output_port()
        self._bounds = MotionBounds(model, request.group)
        self._read_pairs()
        self._nearest = _Nearest()
        self._counts = _Counts()

    def run(self) -> Clearance:
        self._look(0.0)
        touching = self._fixed_violation()
        if touching is not None:
            return self._result(touching)
        if len(self._pairs) == 0:
            return self._verdict(np.inf)
        self._look(self._request.trajectory.duration)
        stack = self._roots()
        while stack:
            node = stack.pop()
            children = self._bound(node)
            if children is None:
                return self._refusal(node)
            stack += children
        return self._verdict(self._tighten())

    def _read_pairs(self) -> None:
        """Read which pairs can collide and change, their margins and common ancestors."""
        inspector = self._model.scene_graph.model_inspector()
        body_of, row = self._bounds.spheres.body_of, self._bounds.row
        names = self._model.body_names
        self._pairs: list[tuple[Any, Any]] = []
        self._names: list[tuple[str, str]] = []
        rows: list[tuple[int, int, int]] = []
        margins: list[float] = []
        self._fixed = fixed = dict[tuple[Any, Any], tuple[str, str]]()
        for id_a, id_b in sorted(inspector.GetCollisionCandidates()):
            a, b = body_of[id_a], body_of[id_b]
            depth = self._bounds.relative_depth(a, b)
            if depth == len(self._bounds.chains[a]) == len(self._bounds.chains[b]):
                fixed[(id_a, id_b)] = (names[a], names[b])
                continue
            self._pairs.append((id_a, id_b))
            self._names.append((names[a], names[b]))
            rows.append((row[a], row[b], depth))
            margins.append(self._request.margins.of(names[a], names[b]))
        self._rows = np.array(rows, dtype=np.intp).reshape(-1, 3)
        wanted = np.array(margins)
        self._margins = wanted
        self._required = np.where(wanted > 0, np.maximum(wanted - _MARGIN_SLACK, 0.0), 0.0)
        self._index = {pair: i for i, pair in enumerate(self._pairs)}

    def _roots(self) -> list[_Node]:
        curve = self._request.trajectory
        widths = np.diff(curve.breaks)
        coefficients = bernstein.from_power(curve.coefficients, widths)
        return [
            _Node(i, float(curve.breaks[i]), float(widths[i]), coefficients[i], None, np.inf)
            for i in reversed(range(curve.num_pieces))
        ]

    def _bound(self, node: _Node) -> list[_Node] | None:
        """Prove a node, or return its halves; None if it cannot be proven."""
        counts = self._counts
        counts.intervals += 1
        if counts.intervals % _DEADLINE_EVERY == 0:
            self._deadline.check("certify")
        left, right = bernstein.halves(node.bernstein)
        motions = self._go_to(node, left[-1])
        open_pairs = (
            np.arange(len(self._pairs), dtype=np.intp) if node.pairs is None else node.pairs
        )
        moved = motions[open_pairs]
        distances = self._distances(open_pairs, moved, node.t0 + node.width / 2)
        if (distances < self._required[open_pairs] - _SOLVER_TOLERANCE).any():
            return None
        lower = distances - moved
        decided = lower > self._required[open_pairs] + _SOLVER_TOLERANCE
        floor = min(node.floor, float(lower[decided].min(initial=np.inf)))
        if decided.all():
            counts.leaves.append(
                _Node(node.piece, node.t0, node.width, node.bernstein, None, floor)
            )
            return []
        half = node.width / 2
        if half < _SHORTEST:
            return None
        rest = open_pairs[~decided]
        return [
            _Node(node.piece, node.t0 + half, half, right, rest, floor),
            _Node(node.piece, node.t0, half, left, rest, floor),
        ]

    def _go_to(self, node: _Node, middle: Array) -> Array:
        """Set the context to a node's middle and return how far each pair can move from there."""
        curve = self._request.trajectory
        q = curve.manifold.plus(curve.bases[node.piece], middle)
        full = self._model.embed(self._request.group, q, self._request.state)
        self._model.plant.SetPositions(self._plant_context, full)
        # exp is 1-Lipschitz on SO(3): the angle between exp(a) and exp(b) is at most |a - b|.
        away = np.abs(node.bernstein - middle[None]).max(axis=0)
        motions = self._bounds.motions(self._plant_context, away)
        a, b, depth = self._rows.T
        return motions[a, depth] + motions[b, depth]

    def _distances(self, pairs: Indices, moved: Array, time: float) -> Array:
        """Return signed distances of some pairs now, or lower bounds where they are far apart."""
        self._counts.queries += 1
        query: Any = self._port.Eval(self._query_context)
        if len(pairs) <= _NARROW:
            found = [
                query.ComputeSignedDistancePairClosestPoints(*self._pairs[i]).distance
                for i in pairs
            ]
            distances = np.array(found)
            self._remember(pairs, distances, time)
            return distances
        enough = float((moved + self._required[pairs]).max()) + 10 * _SOLVER_TOLERANCE
        if not np.isfinite(enough):
            enough = _HORIZONS[-1]
        found = self._within(query, enough)
        distances = np.array([found.get(int(i), enough) for i in pairs])
        known = np.array([int(i) in found for i in pairs], dtype=bool)
        self._remember(pairs[known], distances[known], time)
        return distances

    def _within(self, query: Any, distance: float) -> dict[int, float]:
        """Return the distance of every pair that can change and is nearer than `distance`."""
        found: dict[int, float] = {}
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(distance):
            i = self._index.get((pair.id_A, pair.id_B))
            i = self._index.get((pair.id_B, pair.id_A)) if i is None else i
            if i is not None:
                found[i] = pair.distance
        return found

    def _remember(self, pairs: Indices, distances: Array, time: float) -> None:
        if len(pairs) == 0:
            return
        nearest = self._nearest
        best = int(np.argmin(distances))
        if distances[best] < nearest.distance:
            nearest.distance = float(distances[best])
            nearest.pair, nearest.time = self._names[pairs[best]], time
        slack = distances - self._margins[pairs]
        worst = int(np.argmin(slack))
        if slack[worst] < nearest.slack:
            nearest.slack = float(slack[worst])
            nearest.slack_distance = float(distances[worst])
            nearest.slack_margin = float(self._margins[pairs[worst]])
            nearest.slack_pair, nearest.slack_time = self._names[pairs[worst]], time

    def _look(self, time: float) -> None:
        """Measure the nearest pair at an instant, however far it is."""
        q = self._request.trajectory.positions(np.array([time]))[0]
        full = self._model.embed(self._request.group, q, self._request.state)
        self._model.plant.SetPositions(self._plant_context, full)
        query: Any = self._port.Eval(self._query_context)
        self._counts.queries += 1
        for horizon in _HORIZONS if self._pairs else ():
            found = self._within(query, horizon)
            if found:
                self._remember(
                    np.array(list(found), dtype=np.intp), np.array(list(found.values())), time
                )
                return

    def _fixed_violation(self) -> Check | None:
        """Return a failed check if bodies between which nothing moves are too near."""
        query: Any = self._port.Eval(self._query_context)
        for found in query.ComputeSignedDistancePairwiseClosestPoints(
            max(self._request.margins.largest, _MARGIN_SLACK)
        ):
            names = self._fixed.get((found.id_A, found.id_B))
            names = names or self._fixed.get((found.id_B, found.id_A))
            margin = self._request.margins.of(*names) if names else 0.0
            if names and found.distance < margin - _MARGIN_SLACK:
                where, value = "-".join(names), float(found.distance)
                return Check("clearance", value, margin, "m", 0.0, passed=False, where=where)
        return None

    def _tighten(self) -> float:
        """Halve the intervals that may hide a smaller distance; return a bound on the smallest."""
        leaves = self._counts.leaves
        began = self._counts.queries
        while self._counts.queries - began < _TIGHTEN_QUERIES:
            target = self._nearest.distance - _resolution(self._nearest.distance)
            open_ = [node for node in leaves if node.floor < target]
            if not open_:
                break
            leaves = [node for node in leaves if node.floor >= target]
            for node in open_:
                leaves += self._halve(node)
            self._deadline.check("certify")
        return min(node.floor for node in leaves)

    def _halve(self, node: _Node) -> list[_Node]:
        half = node.width / 2
        children: list[_Node] = []
        for begin, part in zip(
            (node.t0, node.t0 + half), bernstein.halves(node.bernstein), strict=True
        ):
            child = _Node(node.piece, begin, half, part, None, np.inf)
            motions = self._go_to(child, bernstein.halves(part)[0][-1])
            self._counts.intervals += 1
            self._counts.queries += 1
            query: Any = self._port.Eval(self._query_context)
            enough = self._nearest.distance + float(motions.max())
            found = self._within(query, enough)
            indices = np.array(list(found), dtype=np.intp)
            distances = np.array(list(found.values()))
            self._remember(indices, distances, begin + half / 2)
            lower = float((distances - motions[indices]).min(initial=np.inf))
            child.floor = max(node.floor, min(lower, enough - float(motions.max())))
            children.append(child)
        return children

    def _verdict(self, floor: float) -> Clearance:
        nearest = self._nearest
        gap = max(0.0, nearest.distance - floor) if np.isfinite(nearest.distance) else 0.0
        check = Check(
            name="clearance",
            value=nearest.slack_distance,
            bound=nearest.slack_margin,
            unit="m",
            resolution=gap,
            passed=True,
            where="-".join(nearest.slack_pair) if nearest.slack_pair[0] else "",
            time=nearest.slack_time,
        )
        return self._result(check)

    def _refusal(self, node: _Node) -> Clearance:
        """Say where the proof stopped: the pair with the least distance to spare."""
        nearest = self._nearest
        check = Check(
            name="clearance",
            value=nearest.slack_distance,
            bound=nearest.slack_margin,
            unit="m",
            resolution=node.width,
            passed=False,
            where="-".join(nearest.slack_pair),
            time=nearest.slack_time,
        )
        return self._result(check)

    def _result(self, check: Check) -> Clearance:
        nearest, counts = self._nearest, self._counts
        return Clearance(
            check, nearest.distance, nearest.pair, nearest.time, counts.intervals, counts.queries
        )


def _resolution(distance: float) -> float:
    """How exactly the smallest distance is wanted [m]."""
    return max(_RESOLUTION, _RELATIVE_RESOLUTION * distance)
