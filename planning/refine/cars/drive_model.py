"""DriveModel: cost of a car path as a function of its segments, and its local convex model.

The duration is a sum over segments, for the car rests between them, and it is concave in each
length: its linearization never overestimates the gain, and short segments shrink to nothing.
Distances are linear in lengths and curvatures through the poses. Distances and the end at the goal
are penalised (exact penalty); a step of the model is then corrected so that it ends at the goal
(`end_constraint`).
"""

from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.robot.joints import JointLimits
from planning.refine.cars.arc_segments import NOWHERE, ArcSegments, PathSamples, places_on
from planning.refine.cars.drive_evaluation import DriveEvaluation
from planning.refine.cars.drive_problem import DriveProblem
from planning.refine.cars.end_constraint import ended, sides_of, variable_bounds
from planning.refine.cars.segment_times import SegmentTimes
from planning.refine.constraints.clearance_objective import ClearanceObjective
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.curves.curve_evaluation import DISTANCE_PRICE
from planning.refine.model.penalty_qp import PenaltyQp, PenaltyRows

# Spacing of the samples at which distances are kept [m, and rad of another joint], and most samples
# per segment.
_APART, _MOST_PER_LETTER = 0.03, 64
# Signed margin above which pairs are ignored [m].
_REACH = 0.1
# Proximal weight: cost of a change by half of the box's side [s], so that of equal paths the
# nearest is chosen.
_RELUCTANCE = 1e-4
# Penalty of a miss of the goal in the model [s/m].
_END_PRICE = 100.0
# Margin of x and y to their limits, for arcs may bulge between samples [m].
_ROOM = 1e-3
_DIFFERENCE = 1e-6
# Least width of the box, even where bounds leave none.
_SLIT = 1e-9


class DriveModel:
    """Cost and convex model of the car paths of one problem."""

    def __init__(
        self,
        course: DriveProblem,
        nearness: DistanceQuery,
        limits: JointLimits,
        times: SegmentTimes,
        wish: ClearanceObjective | None = None,
    ) -> None:
        """Build the model; angle limits in `limits` are shifted to the turn of the start."""
        self.course = course
        self._nearness, self._limits, self._times, self._wish = nearness, limits, times, wish
        spot = slice(course.at, course.at + 2)
        ends = np.stack([course.start[:2], course.goal[:2]])
        low, high = limits.lower[spot], limits.upper[spot]
        room = np.stack([(ends - low).min(axis=0), (high - ends).min(axis=0)]) / 2
        low, high = np.stack([low, -high]) + np.clip(room, 0.0, _ROOM)
        # x, y >= low and -x, -y >= high.
        self._corner = np.concatenate([low, high])

    def look(self, letters: ArcSegments, watched: PathSamples = NOWHERE) -> DriveEvaluation:
        """Return the evaluation of a path that ends at the goal, with more samples `watched`."""
        spots = watched.and_then(_usual_spots(letters))
        seen = places_on(self.course.start, letters, spots)
        others = letters.others[spots.owners]
        others = others + spots.fractions[:, None] * letters.moves[spots.owners]
        qs = self.course.positions(seen.poses, others)[:-1]
        near = self._nearness.within(qs, _REACH)
        duration = worth = self.duration(letters)
        wished = None
        if self._wish is not None and len(qs):
            wished = self._wish.nearness.within(qs, _REACH)
            worth += self._wish.cost(wished, len(qs))
        outside = float(np.maximum(-self._inside(seen.poses), 0.0).sum())
        return DriveEvaluation(letters, spots, seen, near, wished, duration, worth, outside)

    def duration(self, letters: ArcSegments) -> float:
        """Return the duration of a path [s]."""
        return float(self._times.durations(letters.ways, letters.turns, letters.moves).sum())

    def ended(self, letters: ArcSegments, size: float) -> ArcSegments | None:
        """Return nearby segments that end at the goal, or None."""
        return ended(self.course, letters, size)

    def step(self, seen: DriveEvaluation, size: float) -> tuple[ArcSegments, float]:
        """Return the model's minimiser within a box, and the predicted decrease of the cost [s].

        Its segments need not end at the goal.

        Args:
            seen: Evaluation of the path around which the model is.
            size: About half of the box's side, as the displacement of samples [m].
        """
        letters = seen.letters
        inner = len(seen.letters.others[1:-1].ravel())
        sides = np.concatenate([sides_of(self.course, letters, size), np.full(inner, 2 * size)])
        lower, upper = self._bounds(letters)
        now = letters.variables
        low = np.clip((lower - now) / sides, -1.0, 0.0)
        high = np.maximum(np.clip((upper - now) / sides, 0.0, 1.0), low + _SLIT)
        reluctance = np.full(len(now), _RELUCTANCE)
        rows = [self._end_rows(seen, sides), self._inside_rows(seen, sides)]
        rows.append(self._near_rows(seen, seen.near, sides, DISTANCE_PRICE))
        if self._wish is not None and seen.wished is not None:
            price = self._wish.weight / (len(seen.spots.owners) - 1)
            rows.append(self._near_rows(seen, seen.wished, sides, price))
        haste = self._haste(letters) * sides
        program = PenaltyQp(haste, reluctance, low, high, tuple(rows))
        x = program.solve()
        promised = program.cost(np.zeros_like(x)) - program.cost(x)
        return letters.with_variables(np.clip(now + x * sides, lower, upper)), promised

    def _bounds(self, letters: ArcSegments) -> tuple[Array, Array]:
        lower, upper = variable_bounds(self.course, letters)
        others, count = self.course.others, len(letters) - 1
        return (
            np.concatenate([lower, np.tile(self._limits.lower[others], count)]),
            np.concatenate([upper, np.tile(self._limits.upper[others], count)]),
        )

    def _end_rows(self, seen: DriveEvaluation, sides: Array) -> PenaltyRows:
        slopes = np.zeros((3, len(sides)))
        slopes[:, : seen.places.slopes.shape[2]] = seen.places.slopes[-1]
        return _dense(np.concatenate([slopes, -slopes]) * sides, np.zeros(6), _END_PRICE)

    def _near_rows(
        self, seen: DriveEvaluation, near: DistanceRows, sides: Array, price: float
    ) -> PenaltyRows:
        """Return rows of distances that a step within the box could make too short."""
        course = self.course
        values = seen.carried(near.at, near.gradient, course.at, course.others) * sides
        some = near.spare < np.abs(values).sum(axis=1)
        return _dense(values[some], -near.spare[some], price)

    def _inside_rows(self, seen: DriveEvaluation, sides: Array) -> PenaltyRows:
        """Return rows that keep x and y within their limits."""
        slopes = seen.places.slopes[:, :2]
        values = np.zeros((len(slopes), 4, len(sides)))
        values[:, :, : slopes.shape[2]] = np.concatenate([slopes, -slopes], axis=1)
        values *= sides
        spare = self._inside(seen.places.poses)
        some = spare < np.abs(values).sum(axis=2)
        return _dense(values[some], -spare[some], DISTANCE_PRICE)

    def _inside(self, poses: Float64[np.ndarray, "m 3"]) -> Float64[np.ndarray, "m 4"]:
        """Return the signed margins of x and y to their limits [m]."""
        return np.concatenate([poses[:, :2], -poses[:, :2]], axis=1) - self._corner

    def _haste(self, letters: ArcSegments) -> Array:
        """Return the gradient of the duration by all variables, by finite differences."""
        ways, bends, moves = letters.ways, letters.bends, letters.moves
        k, h = moves.shape[1], _DIFFERENCE
        outwards = np.where(ways < 0, -h, h)
        all_ways = np.concatenate([ways, ways + outwards, *[ways] * (k + 1)])
        all_bends = np.concatenate([bends, bends, bends + h, *[bends] * k])
        shifted = (moves + h * np.eye(k)[:, None]).reshape(k * len(ways), k)
        all_moves = np.concatenate([moves, moves, moves, shifted])
        times = self._times.durations(all_ways, all_ways * all_bends, all_moves)
        times = times.reshape(k + 3, len(ways))
        rates = (times[1:] - times[0]) / np.vstack([outwards, np.full((k + 1, len(ways)), h)])
        between = (rates[2:, :-1] - rates[2:, 1:]).T
        return np.concatenate([rates[0], rates[1], between.ravel()])


def _usual_spots(letters: ArcSegments) -> PathSamples:
    """Return samples evenly along every segment, its end included."""
    longest = np.maximum(np.abs(letters.ways), np.abs(letters.moves).max(axis=1, initial=0.0))
    counts = np.clip(np.ceil(longest / _APART), 1, _MOST_PER_LETTER).astype(int)
    owners = np.repeat(np.arange(len(letters)), counts)
    places = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    return PathSamples(owners, places / counts[owners])


def _dense(values: Array, least: Array, price: float) -> PenaltyRows:
    columns: Any = np.broadcast_to(np.arange(values.shape[1]), values.shape)
    return PenaltyRows(columns, values, least, price)
