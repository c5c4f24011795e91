"""Deviations: the distance between two motions of the same joints at the same instants."""

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory


class Deviations:
    """Deviations of other motions from a given one."""

    def __init__(self, curve: TimedTrajectory, times: Float64[np.ndarray, " n"]) -> None:
        """Cut the motion at its breaks and at the instants of possible breaks of others."""
        self._curve = curve
        self._times = np.union1d(curve.breaks, times)
        self._widths = self._times[1:] - self._times[:-1]
        self._polynomials = (
            local_polynomials(curve, self._times[:-1]) if curve.manifold.is_flat else None
        )

    def of(self, other: TimedTrajectory) -> Float64[np.ndarray, "m nv"]:
        """Return the largest difference of each coordinate of two motions at equal instants.

        One row for each interval between instants at which either may have a break.

        The difference of two polynomials is a polynomial, bounded by its Bernstein coefficients.
        Whole turns do not count. With floating joints the bound is infinite.

        Args:
            other: A motion of the same joints and duration, with breaks among the instants.
        """
        curve = self._curve
        if self._polynomials is None:
            return np.full((1, curve.manifold.num_velocities), np.inf)
        (q, own), (q_other, others) = self._polynomials, local_polynomials(other, self._times[:-1])
        terms, common = own.shape[1], min(own.shape[1], others.shape[1])
        difference = np.zeros((len(own), max(terms, others.shape[1]), own.shape[2]))
        difference[:, :terms] = own
        difference[:, :common] -= others[:, :common]
        np.negative(others[:, common:], out=difference[:, common : others.shape[1]])
        difference[:, 0] = curve.manifold.minus(q, q_other)
        forms = np.abs(bernstein.rows_from_power(difference, self._widths))
        # Maximum over few terms: faster term by term than along the last axis.
        largest = forms[:, :, 0]
        for k in range(1, forms.shape[2]):
            largest = np.maximum(largest, forms[:, :, k])
        return largest.T


def local_polynomials(
    curve: TimedTrajectory, begins: Float64[np.ndarray, " m"]
) -> tuple[Array, Array]:
    """Return positions of a curve at instants, and its polynomials expanded about them.

    By repeated synthetic division; shapes (m, nq) and (m, degree + 1, nv).
    """
    piece, offsets = curve.locate(begins)
    expanded = curve.coefficients[piece]
    rows = np.flatnonzero(offsets)
    if len(rows):
        expanded[rows] = _expand(expanded[rows], offsets[rows, None])
    return curve.bases[piece] + expanded[:, 0], expanded


def _expand(coefficients: Array, offsets: Array) -> Array:
    """Return polynomials expanded about other points; the input is overwritten."""
    terms = np.ascontiguousarray(coefficients.swapaxes(0, 1))
    for i in range(len(terms) - 1):
        for k in range(len(terms) - 2, i - 1, -1):
            terms[k] += offsets * terms[k + 1]
    return terms.swapaxes(0, 1)
