"""Cells: subdivision of a curve into pieces at given parameters."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array, Indices
from planning.domain.curves.curve import Curve, JointSpline
from planning.retime.compose import taylor_shifted
from planning.retime.polynomials import norms

# Smallest distance of edges, relative to the curve's whole parameter; nearer ones are left out.
_MIN_EDGE_SPACING = 1e-7


def cut_at(curve: Curve, edges: Float64[np.ndarray, " n_plus_1"]) -> JointSpline:
    """Return the curve in pieces between given edges, which must include all its breaks."""
    pieces, _ = curve.locate((edges[:-1] + edges[1:]) / 2)
    local = taylor_shifted(curve.coefficients[pieces], edges[:-1] - curve.breaks[pieces])
    return JointSpline(curve.joints, edges, curve.bases[pieces], local)


def even_edges(
    breaks: Float64[np.ndarray, " n_plus_1"], counts: Any
) -> Float64[np.ndarray, " m_plus_1"]:
    """Return edges that cut each piece between breaks into a number (`counts`) of equal parts."""
    counts = np.asarray(counts)
    owners = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(owners)) - (np.cumsum(counts) - counts)[owners]
    edges = within * (np.diff(breaks) / counts)[owners] + breaks[owners]
    return np.append(edges, breaks[-1])


def with_extra_edges(
    edges: Float64[np.ndarray, " n_plus_1"], extra_edges: Sequence[Array]
) -> Float64[np.ndarray, " k_plus_1"]:
    """Return the edges with additional cuts, except those right beside an edge."""
    candidates = np.concatenate([np.zeros(0), *extra_edges])
    near = np.searchsorted(edges, candidates).clip(1, len(edges) - 1)
    distances = np.minimum(np.abs(candidates - edges[near - 1]), np.abs(edges[near] - candidates))
    candidates = np.unique(candidates[distances > _MIN_EDGE_SPACING * (edges[-1] - edges[0])])
    is_separate = np.append(True, np.diff(candidates) > _MIN_EDGE_SPACING * (edges[-1] - edges[0]))
    return np.sort(np.concatenate([edges, candidates[is_separate[: len(candidates)]]]))


def num_parts(curve: Curve, max_length: float) -> Indices:
    """Return the number of equal parts of each piece that makes the parts short.

    Args:
        curve: The curve.
        max_length: Largest length of a part (joint-space length of delta).
    """
    return np.maximum(1, np.ceil(piece_length_bounds(curve) / max_length)).astype(np.int64)


def piece_length_bounds(curve: Curve) -> Float64[np.ndarray, " n"]:
    """Return upper bounds on the length of delta on each piece (joint-space length).

    The bound is the sum of |c_k| k w^k; for a part of a piece it is at most the part's share of
    that.
    """
    widths = np.diff(curve.breaks)[:, None]
    powers = np.arange(curve.coefficients.shape[1])
    return (norms(curve.coefficients) * powers * widths**powers).sum(axis=1)
