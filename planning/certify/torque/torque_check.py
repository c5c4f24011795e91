"""Torque check: joint torques and forces on the whole interval, against the limits on effort.

Segments of the motion are bounded by `torque_series`; those whose bound is above the largest
sampled value are halved, many at once (branch and bound).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.intervals.equal_split import split_equally
from planning.certify.joints.limit_checks import MAX_UTILIZATION
from planning.certify.request import CertifyRequest
from planning.certify.torque.links import links_of
from planning.certify.torque.taylor_torques import TorquePolynomials, torque_series
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Relative gap between the bound and the largest sampled value at which the search stops.
_RELATIVE_GAP = 1e-3
_BATCH_SIZE = 256


@dataclass(frozen=True)
class _Segments:
    """Parts of pieces: piece, middle since its break [s], half width [s], each of shape (n,)."""

    pieces: Any
    middles: Array
    halves: Array

    def select(self, chosen: Any) -> "_Segments":
        return _Segments(self.pieces[chosen], self.middles[chosen], self.halves[chosen])

    @property
    def halved(self) -> "_Segments":
        """Return both halves of each segment."""
        quarter = self.halves / 2
        return _Segments(
            np.concatenate([self.pieces, self.pieces]),
            np.concatenate([self.middles - quarter, self.middles + quarter]),
            np.concatenate([quarter, quarter]),
        )


@dataclass(frozen=True)
class _Utilizations:
    """Torque over limit by segment: bound, value in the middle, and block; each of shape (n,)."""

    upper: Array
    values: Array
    blocks: Any


def torque_check(
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
    *,
    max_joint_motion: float = 0.3,
    max_segments: int = 20_000,
) -> Check:
    """Return the check of the peak torque or force over limit of any joint, a guaranteed bound.

    Joints without limits are skipped. Not included: Coulomb friction and contact.

    Args:
        model: The scene.
        request: The trajectory and its limits.
        deadline: Time limit.
        max_joint_motion: Largest sum of joint motions on an initial segment [rad or m].
        max_segments: Largest number of segments beyond two for each initial one; a motion that
            needs more is refused.

    Raises:
        ModelInvalid: A joint is of a kind that cannot be certified, or a moving body has no known
            mass.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    search = _Search(model, request, deadline, max_segments)
    return search.run(max_joint_motion)


class _Search:
    """Branch and bound over segments."""

    def __init__(
        self, model: DrakeModel, request: CertifyRequest, deadline: Deadline, max_segments: int
    ) -> None:
        self._request, self._deadline, self._max_segments = request, deadline, max_segments
        self._links, self._use_kernel = links_of(model, request), model.uses_kernel
        self._gravity = np.array(model.plant.gravity_field().gravity_vector())
        efforts = request.limits.effort
        self._limited = [i for i in range(len(efforts)) if np.isfinite(efforts[i])]
        self._largest, self._block, self._time = 0.0, "", 0.0

    def run(self, max_joint_motion: float) -> Check:
        if not self._limited:
            return self._torque_result(0.0)
        counts = self._counts(max_joint_motion)
        count, budget = 0, self._max_segments + 2 * len(counts)
        if not counts.sum() <= budget:
            return self._torque_result(float("inf"))
        segments, decided_bound = self._initial_segments(counts.astype(np.int64)), 0.0
        while True:
            utilizations = self._utilizations(segments)
            count += len(segments.halves)
            self._update_largest(segments, utilizations)
            threshold = max(
                self._largest, min(self._largest * (1 + _RELATIVE_GAP), MAX_UTILIZATION)
            )
            is_open = utilizations.upper > threshold
            decided_bound = max(
                decided_bound, self._largest, float(utilizations.upper[~is_open].max(initial=0.0))
            )
            if not is_open.any() or self._largest > MAX_UTILIZATION:
                return self._torque_result(decided_bound)
            if count + 2 * int(is_open.sum()) > budget:
                return self._torque_result(float(utilizations.upper.max()))
            segments = segments.select(is_open).halved

    def _counts(self, max_joint_motion: float) -> Array:
        """Return the number of segments of each piece, so that no joint moves far on any."""
        widths = np.diff(self._request.trajectory.breaks)
        rates = np.abs(self._request.bernstein_forms[1]).max(axis=2).sum(axis=0)
        return np.maximum(1.0, np.ceil(rates * widths / max_joint_motion))

    def _initial_segments(self, counts: Any) -> _Segments:
        """Return the initial segments of the whole motion."""
        widths = np.diff(self._request.trajectory.breaks)
        pieces, within = split_equally(counts)
        halves = (widths / counts)[pieces] / 2
        return _Segments(pieces, (2 * within + 1) * halves, halves)

    def _utilizations(self, segments: _Segments) -> _Utilizations:
        parts: list[tuple[Array, Array]] = []
        for begin in range(0, len(segments.halves), _BATCH_SIZE):
            self._deadline.check("certify")
            chosen = segments.select(slice(begin, begin + _BATCH_SIZE))
            # Overflow gives NaN, which is refused.
            with np.errstate(over="ignore", invalid="ignore"):
                torques = torque_series(
                    self._links,
                    self._gravity,
                    self._request.trajectory,
                    (chosen.pieces, chosen.middles, chosen.halves),
                    use_kernel=self._use_kernel,
                )
                parts.append(self._block_utilizations(torques, chosen.halves))
        upper, values = (
            np.nan_to_num(np.concatenate(part), nan=np.inf) for part in zip(*parts, strict=True)
        )
        blocks = values.argmax(axis=1)
        return _Utilizations(upper.max(axis=1), values.max(axis=1), blocks)

    def _block_utilizations(self, torques: TorquePolynomials, halves: Array) -> tuple[Array, Array]:
        """Return upper bounds and middle values over limits, shape (n, limited blocks)."""
        limits = self._request.limits
        forms = bernstein.about_middle(torques.taylor, halves)
        upper, values = np.empty((2, len(halves), len(self._limited)))
        for column, i in enumerate(self._limited):
            block, limit = list(limits.blocks[i]), limits.effort[i]
            # A polynomial stays in the hull of its coefficients, and a norm is convex.
            peak = np.linalg.norm(forms[:, :, block], axis=2).max(axis=1)
            error = np.linalg.norm(torques.errors[:, block], axis=1)
            upper[:, column] = (peak + error) / limit
            values[:, column] = np.linalg.norm(torques.taylor[:, 0, block], axis=1) / limit
        return upper, values

    def _update_largest(self, segments: _Segments, utilizations: _Utilizations) -> None:
        worst = int(np.argmax(utilizations.values))
        if utilizations.values[worst] > self._largest:
            self._largest = float(utilizations.values[worst])
            self._block = self._request.group.blocks[
                self._limited[int(utilizations.blocks[worst])]
            ][0]
            begin = self._request.trajectory.breaks[segments.pieces[worst]]
            self._time = float(begin + segments.middles[worst])

    def _torque_result(self, value: float) -> Check:
        passed = value <= MAX_UTILIZATION
        return Check("torque", value, MAX_UTILIZATION, "1", 0.0, passed, self._block, self._time)
