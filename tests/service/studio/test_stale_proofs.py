"""A proof is of one revision of a scene: what the studio says once the scene has changed."""

import pytest

from tests.service.studio.unseen import kind_of, plain, studio


@pytest.fixture
def person(real_server):
    with studio(real_server.url) as opened:
        yield opened


def put_a_box(person, position):
    """Add a box by hand, and type where it is."""
    person.set("Add", "box")
    person.reads("revision 2: add box_1")
    person.set("Position [m]", position)
    person.reads("revision 3: move box_1")


def test_a_proof_of_a_revision_before_is_amber_until_it_is_proven_again(person):
    person.click("Plan")
    assert kind_of(person.reads("^Proven")) == "good"
    put_a_box(person, (-2.0, 0.0, 0.3))  # far from everything
    assert kind_of(person.reads("^Proven in revision 1 · the scene has changed since")) == "warn"
    assert not person.field("Execute").disabled
    table = plain(person.reads("tool path"))
    assert "proven in 1" in table
    assert "revision 3" in table
    person.click("Prove it again")
    assert kind_of(person.reads(r"^Proven · \d")) == "good"
    assert not person.field("Prove it again").visible


def test_a_motion_that_does_not_hold_any_more_is_said_to_be_with_one_pair(person):
    person.click("Plan")
    person.reads("^Proven")
    put_a_box(person, (0.4, 0.1, 0.4))  # where the forearm passes
    person.reads("the scene has changed since")
    person.click("Execute")
    refused = plain(person.reads("not_certified"))
    sentence, _, _ = refused.partition("not_certified")
    html = person.reads("^Not proven in revision 3")
    assert kind_of(html) == "bad"
    assert sentence.rstrip(".") in plain(html)
    assert "collide by" in sentence
    assert " mm at " in sentence
    assert not any("^Proven" in plain(line) for line in person.says)
    assert person.field("Execute").disabled


def test_what_is_proven_again_and_does_not_hold_cannot_be_carried_out(person):
    person.click("Plan")
    person.reads("^Proven")
    put_a_box(person, (0.4, 0.1, 0.4))
    person.click("Prove it again")
    assert kind_of(person.reads("^Not proven in revision 3 · .* collide by")) == "bad"
    assert person.field("Execute").disabled
    person.click("Undo")  # nothing is known of that revision
    person.reads("revision 4: undo: move box_1")
    assert not person.field("Execute").disabled
    assert person.field("Prove it again").visible
