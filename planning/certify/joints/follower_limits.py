"""Follower limits: limits of mimic joints on the whole interval of a trajectory.

A follower's coordinate is a multiple of the polynomial of the joint that it follows, plus an
offset.
"""

from collections.abc import Iterator

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.intervals.rounding import UNIT
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array

_RELATIVE_GAP = 1e-8


def follower_excesses(request: CertifyRequest) -> tuple[list[str], Array]:
    """Return the excess of followers over their bounds, as coefficients with rounding errors.

    Returns:
        The follower's name for each bound, and the coefficients, shape (num_bounds, n, k).
    """
    names: list[str] = []
    rows: list[Array] = []
    for follower in request.followers:
        bases = request.trajectory.bases[:, follower.position]
        form = request.forms[0][follower.rate]
        values = follower.multiplier * (form + bases[:, None]) + follower.offset
        hidden = abs(follower.multiplier) * request.rounding[0][follower.rate]
        hidden += 4 * UNIT * (np.abs(values).max() + abs(follower.offset))
        for excess in (values - follower.upper, follower.lower - values):
            if np.isfinite(excess).all():
                names.append(follower.name)
                rows.append(excess + hidden)
    return names, np.stack(rows) if rows else np.zeros((0, 1, 1))


def follower_uses(
    request: CertifyRequest, name: str, order: int
) -> Iterator[tuple[float, str, int, float]]:
    """Yield the peak of a rate over its limit, the follower, the piece, and the fraction of it."""
    for follower in request.followers:
        limit = getattr(follower, name)
        if not np.isfinite(limit):
            continue
        share = abs(follower.multiplier) / limit
        rows = request.forms[order][follower.rate] * share
        top, row, fraction = bernstein.peak(np.concatenate([rows, -rows]), _RELATIVE_GAP)
        hidden = float(request.rounding[order][follower.rate]) * share
        yield max(top, 0.0) + hidden, follower.name, row % len(rows), fraction
