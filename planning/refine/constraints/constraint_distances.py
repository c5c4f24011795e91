"""Path constraints as distances: their signed margins along a curve, with gradients."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.refine.constraints.band_distances import BandDistanceQuery
from planning.refine.constraints.distance_query import DistanceQuery, DistanceRows
from planning.refine.curves.chart import Chart
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.constraints.predicate_constraint import PredicateConstraint

# Step of the difference quotients [rad or m].
_DIFFERENCE_STEP = 1e-6
# Share of a band's inner margin that the audit requires of a curve.
_AUDIT_FRACTION = 1 / 2


class ConstraintDistanceQuery:
    """Distance query that adds boxes, cones and bands to the pairs of bodies.

    The margin of a constraint counts in its own unit, a radian like a metre. Predicates have no
    gradient and are left out.
    """

    def __init__(
        self, distance_query: DistanceQuery, constraints: PathConstraints, chart: Chart
    ) -> None:
        """Add constraints with a gradient to `distance_query`, in coordinates of a chart."""
        self._inner, self._positions = distance_query, chart.positions
        self._constraints = [
            constraint
            for constraint in constraints.constraints
            if isinstance(constraint, BoxConstraint | ConeConstraint)
        ]
        self._band_queries = [
            BandDistanceQuery(constraint, chart)
            for constraint in constraints.constraints
            if isinstance(constraint, BandConstraint)
        ]

    def within(self, qs: Float64[np.ndarray, "m nq"], influence_distance: float) -> DistanceRows:
        """Return pairs and constraints of signed margin below `influence_distance` [m or rad]."""
        parts = [
            query.within(qs, influence_distance) for query in [self._inner, *self._band_queries]
        ]
        parts += [
            self._constraint_rows(constraint, qs, influence_distance)
            for constraint in self._constraints
        ]
        return DistanceRows(
            np.concatenate([part.sample_indices for part in parts]),
            np.concatenate([part.signed_margins for part in parts]),
            np.concatenate([part.gradients for part in parts]),
        )

    def _constraint_rows(
        self, constraint: BoxConstraint | ConeConstraint, qs: Array, influence_distance: float
    ) -> DistanceRows:
        signed_margins = constraint.signed_margins(self._positions(qs)) - constraint.margin
        sample_indices = np.flatnonzero(signed_margins < influence_distance)
        shifted = qs[sample_indices, None] + _DIFFERENCE_STEP * np.eye(qs.shape[1])
        shifted_margins = (
            constraint.signed_margins(self._positions(shifted.reshape(-1, qs.shape[1])))
            - constraint.margin
        )
        gradient = (
            shifted_margins.reshape(shifted.shape[:2]) - signed_margins[sample_indices, None]
        ) / _DIFFERENCE_STEP
        return DistanceRows(sample_indices, signed_margins[sample_indices], gradient)


def audit_constraints(constraints: PathConstraints) -> PathConstraints:
    """Return the constraints that the audit checks at every sample, without predicates.

    A band's inner margin is reduced: a curve optimized onto a bound of a band meets it only to the
    tolerance of the solver.
    """
    checked = [
        constraint
        for constraint in constraints.constraints
        if not isinstance(constraint, PredicateConstraint)
    ]
    return replace(
        constraints,
        constraints=tuple(
            constraint.tightened(_AUDIT_FRACTION * constraint.margin)
            if isinstance(constraint, BandConstraint)
            else constraint
            for constraint in checked
        ),
    )


def predicate_constraints(constraints: PathConstraints) -> tuple[PredicateConstraint, ...]:
    """Return the constraints without gradient."""
    return tuple(
        constraint
        for constraint in constraints.constraints
        if isinstance(constraint, PredicateConstraint)
    )
