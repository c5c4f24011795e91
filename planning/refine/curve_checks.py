"""Auditor: dense collision and constraint check of an optimized curve, at its samples."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import World

# Spacing of the samples (joint-space length) ...
_SAMPLE_SPACING = 0.01
# ... unless that makes fewer or more samples than these.
_MIN_SAMPLES, _MAX_SAMPLES = 400, 2000
# Rounding error of position limits [rad or m].
_POSITION_TOLERANCE = 1e-9
# A predicate is evaluated on this many interleaved subsets of the samples, one after another.
_NUM_SUBSETS = 16


@dataclass(frozen=True)
class DenseSamples:
    """Configurations of a curve at even instants, densely, both ends included.

    Attributes:
        positions: One per row, shape (m, nq).
    """

    positions: Array

    @classmethod
    def of(cls, positions_at: Callable[[int], Array]) -> "DenseSamples":
        """Return the samples of a curve that gives its positions at a number of intervals."""
        positions = positions_at(_MIN_SAMPLES)
        num_intervals = min(int(np.ceil(_length(positions) / _SAMPLE_SPACING)), _MAX_SAMPLES)
        return cls(positions if num_intervals <= _MIN_SAMPLES else positions_at(num_intervals))

    @classmethod
    def of_curve(cls, curve: JointSpline) -> "DenseSamples":
        """Return the samples of a joint spline."""
        return cls.of(lambda n: curve.positions(np.linspace(0.0, 1.0, n + 1)))

    @property
    def length(self) -> float:
        """Joint-space length (radians and metres weigh the same)."""
        return _length(self.positions)

    def is_within_limits(self, limits: JointLimits) -> bool:
        """Return whether all samples keep the position limits."""
        low, high = limits.lower - _POSITION_TOLERANCE, limits.upper + _POSITION_TOLERANCE
        return bool(((self.positions >= low) & (self.positions <= high)).all())

    def satisfy(self, predicates: tuple[PredicateConstraint, ...]) -> bool:
        """Return whether predicates accept all samples, coarse subsets of them first."""
        return all(
            bool(predicate.are_satisfied(self.positions[begin::_NUM_SUBSETS]).all())
            for predicate in predicates
            for begin in range(_NUM_SUBSETS)
        )


class Auditor:
    """Checker of curves of one group with the scene's own collision oracle.

    It samples, so it promises nothing between its samples; the certifier proves that.
    """

    def __init__(
        self,
        world: World,
        group: JointGroup,
        buffers: DistanceBuffers,
        constraints: PathConstraints | None = None,
    ) -> None:
        """Make the oracles: one with the margins, for the ends, one with a part of the buffers."""
        self._constraints = constraints
        self._end_oracle = world.collision_oracle(group, buffers.margins)
        self._padded_oracle = world.collision_oracle(group, buffers.audit_margins)

    def find_violations(self, samples: DenseSamples) -> Array:
        """Return the middle of every interval of s on which a curve is in violation, shape (m,).

        A violation is a pair of bodies below its distance, or a broken path constraint. The
        intervals are in order; none means that every sample is free.
        """
        positions = samples.positions
        free = self._padded_oracle.are_free(positions)
        free[0] = self._end_oracle.is_free(positions[0])
        free[-1] = self._end_oracle.is_free(positions[-1])
        if self._constraints is not None:
            free &= self._constraints.are_satisfied(positions)
        if free.all():
            return np.zeros(0)
        violated = np.flatnonzero(~free)
        runs = np.split(violated, np.flatnonzero(np.diff(violated) > 1) + 1)
        return np.array([run[len(run) // 2] for run in runs]) / (len(positions) - 1)


def curve_length(curve: JointSpline) -> float:
    """Return the curve's joint-space length (radians and metres weigh the same)."""
    return _length(curve.positions(np.linspace(0.0, 1.0, _MIN_SAMPLES + 1)))


def _length(positions: Array) -> float:
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
