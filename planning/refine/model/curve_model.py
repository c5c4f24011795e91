"""CurveModel: cost of a curve by its control points, and its local convex model (a QP).

The duration is that of the minimum-time squared path velocity b along the curve, which depends on
the control points P through bounds that are bilinear in (P, b). They are linearised in both,
distances in P, and the duration is expanded to second order in b. The model's minimiser within a
box around P is the next curve, whose own minimum-time path velocity gives its true cost. Distances
are penalised (exact penalty), not strict; the clearance objective has a variable at every instant:
the shortfall of the nearest pair there.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.robot.joints import JointLimits
from planning.refine.constraints.clearance_objective import ClearanceObjective
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.constraints.rate_bounds import RateBounds
from planning.refine.curves.bspline_basis import Weights, weights_at
from planning.refine.curves.curve_evaluation import DISTANCE_PRICE, CurveEvaluation
from planning.refine.curves.path_velocity import both_ends, duration_gradient, duration_of, grid_of
from planning.refine.model.load_evaluation import path_velocity_along
from planning.refine.model.path_velocity_rows import RATE_PENALTY
from planning.refine.model.penalty_qp import PenaltyQp, PenaltyRows
from planning.refine.model.variable_layout import numbering_of

# Signed margin above which pairs are ignored [m].
_REACH = 0.1
# Proximal weight: cost of moving one control point by half of the box's side, in durations. Many
# sets of control points describe the same motion; the nearest one is chosen.
_RELUCTANCE = 1e-4
# Largest relative decrease and increase of b within one step.
_SLOWER, _FASTER = 0.7, 1.5
# Rates below these shares of their bounds have no row.
_ACCELERATION_SEEN, _SPEED_SEEN = 0.3, 0.4
# Ratio of the penalty of a shortfall beyond the shortfall variable to the cost of that variable: it
# must exceed 1 for the variable to be used.
_DEARER = 2.0
# Least width of the box, even where the position limits leave none.
_SLIT = 1e-6


class CurveModel:
    """Cost and convex model of curves of one number of control points, with distances kept."""

    def __init__(
        self,
        nearness: DistanceQuery,
        limits: JointLimits,
        bounds: RateBounds,
        count: int,
        num_instants: int,
        wish: ClearanceObjective | None = None,
    ) -> None:
        """Build the model, with distances at instants evenly in (0, 1)."""
        self._nearness = nearness
        self._wish = wish
        self._limits = limits
        self._bounds = bounds
        self._grid = grid_of(count)
        num_wishes = 0 if wish is None else num_instants
        self._numbers = numbering_of(count, len(bounds.velocity), num_wishes)
        self._count = count
        self.instants = np.linspace(0.0, 1.0, num_instants + 2)[1:-1]
        self._weights: Weights = weights_at(count, self.instants)
        self._wishing = self._weights

    def keep_distance_at(self, instants: Float64[np.ndarray, " m"]) -> None:
        """Add instants at which distances are kept; earlier evaluations are outdated then."""
        self.instants = np.concatenate([self.instants, instants])
        self._weights = weights_at(self._count, self.instants)

    def look(self, points: Float64[np.ndarray, "k nq"]) -> CurveEvaluation:
        """Return the evaluation of a curve."""
        rates, pace, felt = path_velocity_along(points, self._bounds)
        duration = duration_of(self._grid, pace)
        near = self._nearness.within(self._weights.of(points), _REACH)
        if self._wish is None:
            return CurveEvaluation(points, rates, pace, duration, near, None, duration, felt)
        qs = self._wishing.of(points)
        wished = self._wish.nearness.within(qs, _REACH)
        worth = duration + self._wish.cost(wished, len(qs))
        return CurveEvaluation(points, rates, pace, duration, near, wished, worth, felt)

    def step(self, seen: CurveEvaluation, seconds: float) -> tuple[Array, float]:
        """Return the control points of the model's minimiser, and the predicted decrease [s].

        Args:
            seen: Evaluation of the curve around which the model is.
            seconds: Half of the box's sides around every control point, as the time to cross it at
                the velocity limit.
        """
        side = seconds * self._bounds.velocity
        program = self._program(seen, side)
        x = program.solve()
        points = seen.points.copy()
        points[1:-1] += x[self._numbers.points[1:-1]] * side
        points[1:-1] = np.clip(points[1:-1], self._limits.lower, self._limits.upper)
        still = np.zeros_like(x)
        if self._wish is not None and seen.wished is not None:
            still[self._numbers.lacks] = self._wish.lacks(seen.wished, len(self._numbers.lacks))
        promised = program.cost(still) - program.cost(x)
        return points, promised * seen.duration

    def _program(self, seen: CurveEvaluation, side: Array) -> PenaltyQp:
        """Return the QP, in units of the duration, of the box, and of b itself."""
        points, pace = self._numbers.points[1:-1], self._numbers.pace[1:-1]
        c, q = np.zeros(self._numbers.count), np.full(self._numbers.count, _RELUCTANCE)
        lower, upper = -np.ones_like(c), np.ones_like(c)
        haste = duration_gradient(self._grid, seen.pace)[1:-1] / seen.duration
        # First and second derivative of a duration proportional to b^(-1/2).
        c[pace], q[pace] = -haste, 1.5 * haste
        lower[pace], upper[pace] = -_SLOWER, _FASTER
        lower[points] = np.maximum((self._limits.lower - seen.points[1:-1]) / side, -1.0)
        upper[points] = np.minimum((self._limits.upper - seen.points[1:-1]) / side, 1.0)
        lower = np.minimum(lower, 0.0)
        upper = np.maximum(upper, lower + _SLIT)
        rows = [self._acceleration_rows(seen, side), self._speed_rows(seen, side)]
        if self._bounds.jerk is not None:
            rows.append(self._swing_rows(seen, side, self._bounds.jerk))
        numbers = self._numbers
        rows += [strain.rows(numbers.points, numbers.pace, side) for strain in seen.strains]
        if len(seen.near.at):
            price = DISTANCE_PRICE / seen.duration
            rows.append(self._distance_rows(seen.near, self._weights, side, price))
        if self._wish is not None and seen.wished is not None:
            lacks = self._numbers.lacks
            each = self._wish.weight / (len(lacks) * seen.duration)
            c[lacks], q[lacks], lower[lacks] = each * self._wish.distance, 0.0, 0.0
            rows.append(self._wish_rows(seen.wished, self._wish.distance, side, _DEARER * each))
        return PenaltyQp(c, q, lower, upper, tuple(rows))

    def _acceleration_rows(self, seen: CurveEvaluation, side: Array) -> PenaltyRows:
        """Return rows that bound r'' b + r' u in both signs, by interval, coordinate and end."""
        grid, b = self._grid, seen.pace
        u = np.diff(b) / (2 * grid.step)
        weights = grid.second * both_ends(b)[..., None] + grid.first * u[:, None, None]
        by_point = weights[:, None] * (side / self._bounds.acceleration)[:, None, None]
        at_low, at_high = seen.rates.slopes(grid)
        by_pace = np.stack([at_low * b[:-1, None, None], at_high * b[1:, None, None]], axis=-1)
        values = np.concatenate([by_point, by_pace.transpose(0, 2, 1, 3)], axis=-1)
        now = seen.rates.accelerations(grid, b).transpose(0, 2, 1)
        bounds = self._bounds.signed[:, None, :, None]
        rows = PenaltyRows.between(self._columns(2), values, now, bounds, RATE_PENALTY)
        return rows.taken(rows.least > _ACCELERATION_SEEN - 1)

    def _speed_rows(self, seen: CurveEvaluation, side: Array) -> PenaltyRows:
        """Return rows that bound |r'| sqrt(b) at the low end of every interval but the first."""
        root = np.sqrt(seen.pace[1:-1])
        now = seen.rates.speed[1:, 0] * root[:, None]
        ways = np.sign(now)
        by_point = (self._grid.first[1:, 0] * root[:, None])[:, None, :] * (
            side / self._bounds.velocity * ways
        )[..., None]
        values = np.concatenate([by_point, (np.abs(now) / 2)[..., None]], axis=-1)
        columns = self._columns(1)[1:, :, 0]
        seen_at = np.abs(now) > _SPEED_SEEN
        return PenaltyRows(
            columns[seen_at], -values[seen_at], np.abs(now)[seen_at] - 1, RATE_PENALTY
        )

    def _swing_rows(self, seen: CurveEvaluation, side: Array, jerk: Array) -> PenaltyRows:
        """Return rows that bound |r'''| b^(3/2) at both ends of every interval."""
        b = both_ends(seen.pace) ** 1.5
        now = seen.rates.swing[:, :, None] * b[:, None]
        ways = np.sign(now)
        by_point = (
            self._grid.third[:, None, None]
            * ((side / jerk)[:, None] * b[:, None] * ways)[..., None]
        )
        by_pace = (1.5 * np.abs(now))[..., None] * np.eye(2)
        values = np.concatenate([by_point, by_pace], axis=-1)
        seen_at = np.abs(now) > _SPEED_SEEN
        return PenaltyRows(
            self._columns(2)[seen_at], -values[seen_at], np.abs(now)[seen_at] - 1, RATE_PENALTY
        )

    def _columns(self, num_paces: int) -> Indices:
        """Return columns of 4 control points and of b at one or both ends of every interval.

        Shape (n, nq, 2, 4 + num_paces), the same for both ends.
        """
        points = self._numbers.points[self._grid.owners].transpose(0, 2, 1)
        pace = both_ends(self._numbers.pace)[:, :num_paces]
        pace = np.broadcast_to(pace[:, None], (*points.shape[:2], num_paces))
        columns = np.concatenate([points, pace], axis=-1)
        return np.broadcast_to(columns[:, :, None], (*points.shape[:2], 2, 4 + num_paces))

    def _distance_rows(
        self, near: DistanceRows, weights: Weights, side: Array, price: float
    ) -> PenaltyRows:
        """Return rows of distances that a step within the box could make too short."""
        some = np.flatnonzero(near.spare < np.abs(near.gradient * side).sum(axis=1))
        at, slopes = near.at[some], near.gradient[some] * side
        values = weights.local[at][:, :, None] * slopes[:, None]
        columns = self._numbers.points[weights.owners[at]]
        size = len(some), values[0].size if len(some) else 0
        return PenaltyRows(columns.reshape(size), values.reshape(size), -near.spare[some], price)

    def _wish_rows(
        self, near: DistanceRows, distance: float, side: Array, price: float
    ) -> PenaltyRows:
        """Return rows of target distances minus the shortfall variables, over the distance."""
        rows = self._distance_rows(near, self._wishing, side, price)
        some = np.flatnonzero(near.spare < np.abs(near.gradient * side).sum(axis=1))
        lacks = self._numbers.lacks[near.at[some]]
        return replace(
            rows,
            columns=np.column_stack([rows.columns, lacks]),
            values=np.column_stack([rows.values, np.full(len(some), distance)]),
        )
