"""Follower limits: limits of mimic joints on the whole interval of a trajectory.

A follower's coordinate is a multiple of the polynomial of the joint that it follows, plus an
offset.
"""

from collections.abc import Iterator

import numpy as np

from planning.certify.intervals import bernstein
from planning.certify.intervals.rounding import UNIT_ROUNDOFF
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array

# Gap between upper bounds and sampled values, relative to the limit.
_RELATIVE_GAP = 1e-8


def follower_excesses(request: CertifyRequest) -> tuple[list[str], Array]:
    """Return the excess of followers over their bounds, as coefficients with rounding errors.

    Returns:
        The follower's name for each bound, and the coefficients, shape (num_bounds, n, k).
    """
    names: list[str] = []
    rows: list[Array] = []
    for follower in request.followers:
        bases = request.trajectory.bases[:, follower.position_index]
        form = request.bernstein_forms[0][follower.velocity_index]
        values = follower.multiplier * (form + bases[:, None]) + follower.offset
        rounding_error = (
            abs(follower.multiplier) * request.rounding_errors[0][follower.velocity_index]
        )
        rounding_error += 4 * UNIT_ROUNDOFF * (np.abs(values).max() + abs(follower.offset))
        for excess in (values - follower.upper, follower.lower - values):
            if np.isfinite(excess).all():
                names.append(follower.name)
                rows.append(excess + rounding_error)
    return names, np.stack(rows) if rows else np.zeros((0, 1, 1))


def follower_utilizations(
    request: CertifyRequest, name: str, order: int
) -> Iterator[tuple[float, str, int, float]]:
    """Yield the peak of a rate over its limit, the follower, the piece, and the fraction of it."""
    for follower in request.followers:
        limit = getattr(follower, name)
        if not np.isfinite(limit):
            continue
        scale = abs(follower.multiplier) / limit
        rows = request.bernstein_forms[order][follower.velocity_index] * scale
        peak, row, fraction = bernstein.peak(np.concatenate([rows, -rows]), _RELATIVE_GAP)
        rounding_error = float(request.rounding_errors[order][follower.velocity_index]) * scale
        yield max(peak, 0.0) + rounding_error, follower.name, row % len(rows), fraction
