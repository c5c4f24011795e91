"""Cut a curve into pieces of its own choosing."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.curves.curve import Curve, JointSpline
from planning.retime.compose import shifted
from planning.retime.polynomials import norms

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Counts = np.ndarray[Any, np.dtype[np.int64]]

# Edges nearer than this to the one before are left out, relative to the curve's whole parameter.
_APART = 1e-7


def cut_at(curve: Curve, edges: Float64[np.ndarray, " n_plus_1"]) -> JointSpline:
    """Return the curve in pieces between given edges, among which all its breaks are."""
    pieces, _ = curve.locate((edges[:-1] + edges[1:]) / 2)
    local = shifted(curve.coefficients[pieces], edges[:-1] - curve.breaks[pieces])
    return JointSpline(curve.joints, edges, curve.bases[pieces], local)


def even_edges(
    breaks: Float64[np.ndarray, " n_plus_1"], counts: Any
) -> Float64[np.ndarray, " m_plus_1"]:
    """Return edges that cut each piece between breaks into so many equal parts."""
    parts = [
        np.linspace(a, b, n + 1)[:-1]
        for a, b, n in zip(breaks[:-1], breaks[1:], counts, strict=True)
    ]
    return np.append(np.concatenate(parts), breaks[-1])


def with_cuts(
    edges: Float64[np.ndarray, " n_plus_1"], cuts: Sequence[Array]
) -> Float64[np.ndarray, " k_plus_1"]:
    """Return the edges with more of them, but for those that have one right beside them."""
    more = np.concatenate([np.zeros(0), *cuts])
    near = np.searchsorted(edges, more).clip(1, len(edges) - 1)
    room = np.minimum(np.abs(more - edges[near - 1]), np.abs(edges[near] - more))
    more = np.unique(more[room > _APART * (edges[-1] - edges[0])])
    apart = np.append(True, np.diff(more) > _APART * (edges[-1] - edges[0]))
    return np.sort(np.concatenate([edges, more[apart[: len(more)]]]))


def num_short(curve: Curve, longest: float) -> Counts:
    """Return into how many equal parts to cut each piece, so that delta moves little on them.

    Args:
        curve: The curve.
        longest: How far it may move on a part, at most (joint-space length).
    """
    return np.maximum(1, np.ceil(ways(curve) / longest)).astype(np.int64)


def ways(curve: Curve) -> Float64[np.ndarray, " n"]:
    """Return bounds on how far delta moves on each piece (joint-space length).

    The sum of |c_k| k w^k; of a part of a piece it is no more than the part's share of that.
    """
    widths = np.diff(curve.breaks)[:, None]
    powers = np.arange(curve.coefficients.shape[1])
    return (norms(curve.coefficients) * powers * widths**powers).sum(axis=1)
