"""Cutting convex pieces loses nothing and adds nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.kernel.coverings.convex_polytope import ConvexPolytope
from planning.kernel.coverings.outer_polytope import OuterPolytope
from planning.kernel.coverings.power_cells import power_cells
from planning.kernel.coverings.solid import Solid
from tests.kernel.bodies import hull
from tests.profiles import num_cases


@pytest.fixture(autouse=True)
def _only_with_kernel() -> None:
    """Pieces need no native code."""


def volume(piece: ConvexPolytope) -> float:
    """Return the volume by the divergence theorem, from fans of each face's corners in turn."""
    middle = piece.corners.mean(axis=0)
    total = 0.0
    for face in np.unique(piece.faces):
        ring = piece.corners[(piece.faces == face).any(axis=1)] - middle
        center = ring.mean(axis=0)
        _, _, axes = np.linalg.svd(ring - center)
        turn = np.argsort(np.arctan2(*((ring - center) @ axes[:2].T).T), kind="stable")
        ring = ring[turn]
        fans = np.stack([np.broadcast_to(center, ring.shape), ring, np.roll(ring, -1, axis=0)], 1)
        total += float(np.abs(np.linalg.det(fans)).sum()) / 6
    return total


def random_cut(piece: ConvexPolytope, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    inside = rng.dirichlet(np.ones(len(piece.corners))) @ piece.corners
    return n, float(n @ inside)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), cuts=st.integers(1, 12))
def test_both_parts_of_a_piece_have_its_volume(seed: int, cuts: int) -> None:
    rng = np.random.default_rng(seed)
    piece = ConvexPolytope.box(-rng.uniform(0.1, 1, 3), rng.uniform(0.1, 1, 3))
    for face in range(6, 6 + cuts):
        n, d = random_cut(piece, rng)
        kept, rest = piece.clipped(n, d, face), piece.clipped(-n, -d, face)
        assert volume(kept) + volume(rest) == pytest.approx(volume(piece), rel=1e-9)
        # Euler: a polytope with three faces at every corner.
        assert len(kept.corners) == 2 * (len(np.unique(kept.faces)) - 2)
        assert len(kept.edges) * 2 == len(kept.corners) * 3
        piece = kept


def test_a_plane_that_misses_takes_all_or_nothing() -> None:
    box = ConvexPolytope.box(np.zeros(3), np.ones(3))
    n = np.array([0.0, 0.0, 1.0])
    assert box.clipped(n, 2.0, 6) is box
    empty = box.clipped(n, -1.0, 6)
    assert not len(empty.corners)
    assert not len(empty.clipped(n, 0.5, 7).corners)


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12))
def test_power_cells_share_out_all_of_a_piece(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    piece = OuterPolytope.of(Solid.of(hull(seed, 20, 0.3, 0.2, 0.1))).v_representation
    balls = np.column_stack([rng.uniform(-0.3, 0.3, (count, 3)), rng.uniform(0.01, 0.3, count)])
    cells = power_cells(piece, balls, 1e-10)
    points = rng.dirichlet(np.full(len(piece.corners), 0.1), 500) @ piece.corners
    powers = ((points[:, None] - balls[:, :3]) ** 2).sum(axis=2) - balls[:, 3] ** 2
    owners = np.argmin(powers, axis=1)
    farthest = np.array([
        np.linalg.norm(cell - ball[:3], axis=1).max(initial=-np.inf)
        for cell, ball in zip(cells, balls, strict=True)
    ])
    away = np.linalg.norm(points - balls[owners, :3], axis=1)
    assert (away <= farthest[owners] + 1e-12).all()


@settings(max_examples=num_cases(6))
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(4, 80))
def test_the_polytope_around_a_hull_contains_it_and_is_close(seed: int, count: int) -> None:
    shape = hull(seed, count, 0.3, 0.2, 0.1)
    around = OuterPolytope.of(Solid.of(shape))
    heights = shape.vertices @ around.planes[:, :3].T - around.planes[:, 3]
    assert heights.max() <= 0
    assert len(around.planes) <= 120
    assert Solid.of(shape).depth(around.v_representation.corners).min() > -0.01
