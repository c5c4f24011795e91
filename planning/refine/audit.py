"""Auditor: dense collision and constraint check of an optimised curve."""

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import JointSpline
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.world import World

# Spacing of the samples (joint-space length) ...
_STEP = 0.01
# ... unless that makes fewer or more samples than these.
_FEWEST, _MOST = 400, 2000
_POSITION_DUST = 1e-9
# A predicate is evaluated on this many interleaved subsets of the samples, one after another.
_GLANCES = 16


class Auditor:
    """Checker of curves of one group with the scene's own collision oracle.

    It samples, so it promises nothing between its samples; the certifier proves that.
    """

    def __init__(
        self,
        world: World,
        group: JointGroup,
        buffers: DistanceBuffers,
        rules: PathConstraints | None = None,
    ) -> None:
        """Make the oracles: one with the margins, for the ends, one with a part of the buffers."""
        self._rules = rules
        self._exact = world.collision_oracle(group, buffers.margins)
        self._padded = world.collision_oracle(group, buffers.audited)

    def violated(self, curve: JointSpline) -> Array:
        """Return the middle of every interval of s on which the curve is in violation, shape (m,).

        A violation is a pair of bodies below its distance, or a broken path constraint. The
        intervals are in order; none means that every sample is free.
        """
        count = int(np.clip(np.ceil(length_of(curve) / _STEP), _FEWEST, _MOST))
        s = np.linspace(0.0, 1.0, count + 1)
        positions = curve.positions(s)
        free = self._padded.are_free(positions)
        free[0] = self._exact.is_free(positions[0])
        free[-1] = self._exact.is_free(positions[-1])
        if self._rules is not None:
            free &= self._rules.are_kept(positions)
        taken = np.flatnonzero(~free)
        stretches = np.split(taken, np.flatnonzero(np.diff(taken) > 1) + 1)
        return np.array([s[stretch[len(stretch) // 2]] for stretch in stretches if len(stretch)])


def is_accepted(curve: JointSpline, rules: tuple[PredicateConstraint, ...]) -> bool:
    """Return whether predicates accept all samples of the curve, coarse subsets of them first."""
    count = int(np.clip(np.ceil(length_of(curve) / _STEP), _FEWEST, _MOST))
    positions = curve.positions(np.linspace(0.0, 1.0, count + 1))
    looks = [positions[begin::_GLANCES] for begin in range(_GLANCES)]
    return all(bool(rule.are_kept(some).all()) for rule in rules for some in looks)


def within_limits(curve: JointSpline, limits: JointLimits) -> bool:
    """Return whether samples of the curve keep the position limits."""
    positions = curve.positions(np.linspace(0.0, 1.0, _FEWEST + 1))
    low, high = limits.lower - _POSITION_DUST, limits.upper + _POSITION_DUST
    return bool(((positions >= low) & (positions <= high)).all())


def length_of(curve: JointSpline) -> float:
    """Return the curve's joint-space length (radians and metres weigh the same)."""
    positions = curve.positions(np.linspace(0.0, 1.0, _FEWEST + 1))
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())
