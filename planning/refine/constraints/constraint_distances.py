"""Path constraints as distances: their signed margins along a curve, with gradients."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.constraints.band_distances import BandNearness
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.curves.chart import Chart
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.constraints.predicate_constraint import PredicateConstraint

# Step of the difference quotients [rad or m].
_STEP = 1e-6
# Share of a band's inner margin that the audit requires of a curve.
_AUDITED = 1 / 2


class RuledNearness:
    """Distance query that adds boxes, cones and bands to the pairs of bodies.

    The margin of a constraint counts in its own unit, a radian like a metre. Predicates have no
    gradient and are left out.
    """

    def __init__(self, inner: DistanceQuery, rules: PathConstraints, chart: Chart) -> None:
        """Add constraints with a gradient to `inner`, in coordinates of a chart."""
        self._inner, self._positions = inner, chart.positions
        self._rules = [
            rule for rule in rules.rules if isinstance(rule, BoxConstraint | ConeConstraint)
        ]
        self._bands = [
            BandNearness(rule, chart) for rule in rules.rules if isinstance(rule, BandConstraint)
        ]

    def within(self, qs: Float64[np.ndarray, "m nq"], reach: float) -> DistanceRows:
        """Return pairs and constraints with a signed margin below `reach` [m or rad]."""
        near = [measure.within(qs, reach) for measure in [self._inner, *self._bands]]
        near += [self._near(rule, qs, reach) for rule in self._rules]
        return DistanceRows(
            np.concatenate([part.at for part in near]),
            np.concatenate([part.spare for part in near]),
            np.concatenate([part.gradient for part in near]),
        )

    def _near(self, rule: BoxConstraint | ConeConstraint, qs: Array, reach: float) -> DistanceRows:
        spare = rule.spares(self._positions(qs)) - rule.room
        at = np.flatnonzero(spare < reach)
        moved = qs[at, None] + _STEP * np.eye(qs.shape[1])
        beyond = rule.spares(self._positions(moved.reshape(-1, qs.shape[1]))) - rule.room
        gradient = (beyond.reshape(moved.shape[:2]) - spare[at, None]) / _STEP
        return DistanceRows(at, spare[at], gradient)


def audited(rules: PathConstraints) -> PathConstraints:
    """Return the constraints that the audit checks at every sample, without predicates.

    A band's inner margin is reduced: a curve optimised onto a bound of a band meets it only to the
    tolerance of the solver.
    """
    kept = [rule for rule in rules.rules if not isinstance(rule, PredicateConstraint)]
    return replace(
        rules,
        rules=tuple(
            rule.leaving(_AUDITED * rule.room) if isinstance(rule, BandConstraint) else rule
            for rule in kept
        ),
    )


def predicates(rules: PathConstraints) -> tuple[PredicateConstraint, ...]:
    """Return the constraints without gradient."""
    return tuple(rule for rule in rules.rules if isinstance(rule, PredicateConstraint))
