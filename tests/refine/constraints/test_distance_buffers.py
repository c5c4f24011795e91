"""Buffers: the required distance of a pair is satisfied at the start and at the goal."""

from hypothesis import given
from hypothesis import strategies as st

from planning.refine.constraints.distance_buffers import DistanceBuffers
from planning.world.collision.margins import PairMargins

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
