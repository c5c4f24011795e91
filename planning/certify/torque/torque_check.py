"""Torque check: joint torques and forces on the whole interval, against the limits on effort.

Segments of the motion are bounded by `torque_series`; those whose bound is above the largest
sampled value are halved, many at once (branch and bound).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.intervals.equal_parts import split_equally
from planning.certify.joints.limit_checks import MAX_UTILISATION
from planning.certify.request import CertifyRequest
from planning.certify.torque.links import links_of
from planning.certify.torque.taylor_torques import Torques, torque_series
from planning.domain.arrays import Array
from planning.domain.report.certificate import Check
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Relative gap between the bound and the largest sampled value at which the search stops.
_GAP = 1e-3
_AT_ONCE = 256


@dataclass(frozen=True)
class _Segments:
    """Parts of pieces: piece, middle since its break [s], half width [s], each of shape (n,)."""

    pieces: Any
    middles: Array
    halves: Array

    def only(self, chosen: Any) -> "_Segments":
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
class _Uses:
    """Torque over limit by segment: bound, value in the middle, and block; each of shape (n,)."""

    upper: Array
    seen: Array
    blocks: Any


def torque_check(
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
    *,
    far: float = 0.3,
    most: int = 20_000,
) -> Check:
    """Return the check of the peak torque or force over limit of any joint, a guaranteed bound.

    Joints without limits are skipped. Not included: Coulomb friction and contact.

    Args:
        model: The scene.
        request: The trajectory and its limits.
        deadline: Time limit.
        far: Largest sum of joint motions on an initial segment [rad or m].
        most: Largest number of segments beyond two for each initial one; a motion that needs more
            is refused.

    Raises:
        ModelInvalid: A joint is of a kind that cannot be certified, or a moving body has no known
            mass.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    search = _Search(model, request, deadline, most)
    return search.run(far)


class _Search:
    """Branch and bound over segments."""

    def __init__(
        self, model: DrakeModel, request: CertifyRequest, deadline: Deadline, most: int
    ) -> None:
        self._request, self._deadline, self._most = request, deadline, most
        self._links = links_of(model, request)
        self._gravity = np.array(model.plant.gravity_field().gravity_vector())
        efforts = request.limits.effort
        self._limited = [i for i in range(len(efforts)) if np.isfinite(efforts[i])]
        self._seen, self._block, self._time = 0.0, "", 0.0

    def run(self, far: float) -> Check:
        if not self._limited:
            return self._verdict(0.0)
        counts = self._counts(far)
        count, budget = 0, self._most + 2 * len(counts)
        if not counts.sum() <= budget:
            return self._verdict(float("inf"))
        segments, settled = self._first(counts.astype(np.int64)), 0.0
        while True:
            uses = self._uses(segments)
            count += len(segments.halves)
            self._remember(segments, uses)
            enough = max(self._seen, min(self._seen * (1 + _GAP), MAX_UTILISATION))
            is_open = uses.upper > enough
            settled = max(settled, self._seen, float(uses.upper[~is_open].max(initial=0.0)))
            if not is_open.any() or self._seen > MAX_UTILISATION:
                return self._verdict(settled)
            if count + 2 * int(is_open.sum()) > budget:
                return self._verdict(float(uses.upper.max()))
            segments = segments.only(is_open).halved

    def _counts(self, far: float) -> Array:
        """Return the number of segments of each piece, so that no joint moves far on any."""
        widths = np.diff(self._request.trajectory.breaks)
        rates = np.abs(self._request.forms[1]).max(axis=2).sum(axis=0)
        return np.maximum(1.0, np.ceil(rates * widths / far))

    def _first(self, counts: Any) -> _Segments:
        """Return the initial segments of the whole motion."""
        widths = np.diff(self._request.trajectory.breaks)
        pieces, within = split_equally(counts)
        halves = (widths / counts)[pieces] / 2
        return _Segments(pieces, (2 * within + 1) * halves, halves)

    def _uses(self, segments: _Segments) -> _Uses:
        parts: list[tuple[Array, Array]] = []
        for begin in range(0, len(segments.halves), _AT_ONCE):
            self._deadline.check("certify")
            chosen = segments.only(slice(begin, begin + _AT_ONCE))
            # Overflow gives NaN, which is refused.
            with np.errstate(over="ignore", invalid="ignore"):
                found = torque_series(
                    self._links,
                    self._gravity,
                    self._request.trajectory,
                    (chosen.pieces, chosen.middles, chosen.halves),
                )
                parts.append(self._shares(found, chosen.halves))
        upper, seen = (
            np.nan_to_num(np.concatenate(part), nan=np.inf) for part in zip(*parts, strict=True)
        )
        blocks = seen.argmax(axis=1)
        return _Uses(upper.max(axis=1), seen.max(axis=1), blocks)

    def _shares(self, torques: Torques, halves: Array) -> tuple[Array, Array]:
        """Return upper bounds and middle values over limits, shape (n, limited blocks)."""
        limits = self._request.limits
        forms = bernstein.about_middle(torques.taylor, halves)
        upper, seen = np.empty((2, len(halves), len(self._limited)))
        for column, i in enumerate(self._limited):
            block, limit = list(limits.blocks[i]), limits.effort[i]
            # A polynomial stays in the hull of its coefficients, and a norm is convex.
            top = np.linalg.norm(forms[:, :, block], axis=2).max(axis=1)
            missed = np.linalg.norm(torques.missed[:, block], axis=1)
            upper[:, column] = (top + missed) / limit
            seen[:, column] = np.linalg.norm(torques.taylor[:, 0, block], axis=1) / limit
        return upper, seen

    def _remember(self, segments: _Segments, uses: _Uses) -> None:
        top = int(np.argmax(uses.seen))
        if uses.seen[top] > self._seen:
            self._seen = float(uses.seen[top])
            self._block = self._request.group.blocks[self._limited[int(uses.blocks[top])]][0]
            begin = self._request.trajectory.breaks[segments.pieces[top]]
            self._time = float(begin + segments.middles[top])

    def _verdict(self, value: float) -> Check:
        passed = value <= MAX_UTILISATION
        return Check("torque", value, MAX_UTILISATION, "1", 0.0, passed, self._block, self._time)
