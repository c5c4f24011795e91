"""Buffers: the required distance of a pair is satisfied at the start and at the goal."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.world.collision.margins import PairMargins
from planning.world.kernel.kernel_scene import kernel_scene_of
from planning.world.loading.load_world import load_world

SPARE = st.floats(0, 0.05)
MARGIN = st.floats(0, 0.05)


@given(spare=SPARE, margin=MARGIN, stated=MARGIN)
def test_between_the_margin_and_half_of_what_there_is(spare, margin, stated):
    near = ("arm::hand", "can")
    margins = PairMargins(margin, {("arm::hand", "shelf"): stated})
    buffers = DistanceBuffers(margins, {near: spare})
    assert (
        margin <= buffers.audit_margins.of(*near) <= buffers.threshold(*near) <= margin + spare / 2
    )
    assert (
        stated
        < buffers.audit_margins.of("shelf", "arm::hand")
        < buffers.threshold("shelf", "arm::hand")
    )
    assert (
        margin
        < buffers.audit_margins.of("arm::arm", "wall")
        < buffers.threshold("arm::arm", "wall")
    )


@given(spare=SPARE, margin=MARGIN)
def test_links_of_one_robot_are_audited_at_their_own_margin(spare, margin):
    links = ("arm::forearm", "arm::hand")
    buffers = DistanceBuffers(PairMargins(margin), {links: spare})
    assert buffers.audit_margins.of(*links) == 0.0
    # The ends always satisfy the required distances.
    assert buffers.threshold(*links) < max(spare, 1e-12)
    assert DistanceBuffers(PairMargins(margin)).threshold(*links) > 0


def test_the_nearer_end_counts(pickup):
    group = pickup.group("arm")
    home = pickup.configuration(group, "home")
    ends = pickup.embed(group, home[None])
    margins = pickup.margins()
    one = DistanceBuffers.from_ends(pickup, margins, ends)
    for pair in pickup.distance_probe(margins).pairs_within(ends[0], margins.largest + 0.005):
        assert one.signed_margins[pair.bodies] == pair.distance - margins.of(*pair.bodies)


@pytest.mark.parametrize("margin", [0.0, 0.02, 0.06])
def test_the_kernel_leaves_out_only_ends_without_near_pairs(pickup, margin):
    alone = load_world(pickup.scene, pickup.library, kernel=False)
    limits = pickup.limits(pickup.group("arm"))
    rng = np.random.default_rng(3)
    low, high = np.maximum(limits.lower, -3), np.minimum(limits.upper, 3)
    ends = pickup.embed(pickup.group("arm"), rng.uniform(low, high, (40, len(low))))
    scene, margins = kernel_scene_of(pickup.drake), pickup.margins(margin)
    near = [scene.has_near_pair(end, margins.largest + 0.006) for end in ends]
    assert 0 < sum(near) < len(near)
    for end, is_near in zip(ends, near, strict=True):
        ours, theirs = (DistanceBuffers.from_ends(w, margins, end[None]) for w in (pickup, alone))
        assert ours.signed_margins == theirs.signed_margins
        assert is_near or not ours.signed_margins
