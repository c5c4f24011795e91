"""Objects that are changed by typing: one step for what was typed, and taken back as one."""

import pytest

from service.studio.editing.settled import Settled
from tests.service.servers import until
from tests.service.studio.unseen import plain, studio


@pytest.fixture
def person(real_server):
    with studio(real_server.url) as opened:
        opened.set("Add", "box")
        opened.reads("^revision 2: add box_1")
        opened.server = real_server
        yield opened


def value(person, label):
    return person.field(label).value


def test_keys_in_a_row_are_one_edit_and_one_undo(person):
    for typed in (1.0, 19.0, 0.3):
        person.set("Side y [m]", typed)
    person.reads("^revision 3: resize box_1$")
    person.click("Undo")
    person.reads("^revision 4: undo: resize box_1$")
    until(lambda: value(person, "Side y [m]") == 0.1)


def test_a_size_that_cannot_be_is_said_and_the_old_one_comes_back(person):
    person.set("Side x [m]", -1.0)
    person.reads("^Side x must be above 0$")
    until(lambda: value(person, "Side x [m]") == 0.1)
    person.set("Name", "a box")
    person.reads("is no name")
    until(lambda: value(person, "Name") == "box_1")


def test_an_object_is_moved_turned_and_renamed(person):
    person.set("Position [m]", (0.5, -0.5, 0.4))
    person.set("Roll, pitch, yaw [rad]", (0.1, -0.2, 3.0))
    person.reads("^revision 3: move box_1$")
    person.set("Name", "crate")
    person.reads("^revision 4: rename box_1 to crate$")
    assert value(person, "Object") == "crate"
    assert value(person, "Position [m]") == pytest.approx((0.5, -0.5, 0.4))
    assert value(person, "Roll, pitch, yaw [rad]") == pytest.approx((0.1, -0.2, 3.0))
    person.click("Undo")
    person.reads("^revision 5: undo: rename box_1 to crate$")
    until(lambda: "box_1" in person.field("Object").options)


def test_the_gizmo_of_an_object_goes_while_a_goal_is_looked_for(person):
    gizmo = person.gizmo("/edit_gizmo")
    assert gizmo.visible
    person.set("Goal", "drag the tool")
    assert not gizmo.visible
    assert person.gizmo("/gizmo").visible
    until(lambda: any("arm pose" in plain(line) for line in person.says))


def test_a_place_that_is_dragged_to_is_the_one_that_is_shown(person):
    person.drag(person.gizmo("/edit_gizmo"), (0.41234567, -0.30001, 0.25))
    person.reads("^revision 3: move box_1$")
    assert value(person, "Position [m]") == (0.4123, -0.3, 0.25)
    newest = person.server.ask("GET", "/v1/scenes")["items"][0]["id"]
    document = person.server.ask("GET", f"/v1/scenes/{newest}")["document"]
    (box,) = [entry for entry in document["objects"] if entry["name"] == "box_1"]
    assert tuple(box["pose"]["position"]) == (0.4123, -0.3, 0.25)


def test_only_what_was_asked_last_is_done_and_once():
    done = []
    settled = Settled(lambda work: work(), rest=0.05)
    for i in range(5):
        settled.ask(lambda i=i: done.append(i))
    until(lambda: done)
    assert done == [4]
    settled.ask(lambda: done.append(5))
    settled.drop()
    settled.ask(lambda: done.append(6))
    until(lambda: len(done) > 1)
    assert done == [4, 6]
