"""Where things stand: buttons above all that comes and goes, and the tab that explains."""

import re

import pytest

from tests.service.studio.unseen import plain, studio

BAR = ["Plan", "Cancel", "Execute", "Pause", "Stop", "Speed [x plan]"]
# Of these one is in the other's place: both are never there at once.
IN_PLACE_OF = {"Cancel": "Plan", "Pause": "Execute", "Resume": "Execute"}


@pytest.fixture(scope="module")
def person(real_server):
    with studio(real_server.url) as opened:
        yield opened


def uuid(person, label):
    return person.field(label)._impl.uuid


def containers(person):
    return person.browser.gui._container_handle_from_uuid


def rows(person, uuid):
    """All that stands in a container, in the order in which the page shows it."""
    found = []
    children = [*getattr(containers(person)[uuid], "_children", {}).values()]
    for child in sorted(children, key=lambda child: getattr(child, "order", 0.0)):
        inner = child._impl.uuid if hasattr(child, "_impl") else None
        found.append(child)
        if inner in containers(person):
            found += rows(person, inner)
    return found


def tab_of(person, label):
    """The container of a tab, from an input somewhere in it."""
    place = person.field(label)._impl.parent_container_id
    while not hasattr(containers(person)[place], "_parent"):
        place = containers(person)[place]._impl.parent_container_id
    return place


def above_and_in_the_bar(person):
    """What stands in the tab up to the last button of the bar: each with what it is."""
    all_rows = rows(person, tab_of(person, "Plan"))
    last = max(i for i, row in enumerate(all_rows) if getattr(row, "label", None) == BAR[-1])
    return all_rows[: last + 1]


def height(person):
    """What takes room there, one that takes turns with another counted as that one."""
    labels = [getattr(row, "label", None) for row in above_and_in_the_bar(person) if row.visible]
    return [IN_PLACE_OF.get(label, label) for label in labels]


def test_nothing_stands_above_the_buttons_but_the_buttons(person):
    labels = [getattr(row, "label", None) for row in above_and_in_the_bar(person)]
    assert labels == [None, *BAR]  # the first is the folder that they stand in


def test_the_buttons_take_the_same_room_whatever_goes_on(person):
    places = {label: uuid(person, label) for label in BAR}
    first = height(person)
    person.click("Plan")
    person.reads("^Proven")
    assert height(person) == first
    person.set("Speed [x plan]", 0.2)
    person.start("Execute")
    person.reads("executing")
    assert height(person) == first
    person.click("Stop")
    person.reads("^canceled")
    assert height(person) == first
    assert {label: uuid(person, label) for label in BAR} == places


def test_what_is_said_stands_below_the_goal(person):
    all_rows = rows(person, tab_of(person, "Plan"))
    labels = [getattr(row, "label", None) for row in all_rows]
    said = [i for i, row in enumerate(all_rows) if "planned in" in str(getattr(row, "content", ""))]
    assert said
    assert labels.index("Speed [x plan]") < labels.index("Goal") < min(said)


def test_the_help_says_what_each_button_and_ghost_is_and_leads_to_the_api(person):
    (html,) = [html for html in person.says if "plans motions of robots" in html]
    text = plain(html)
    for word in ("Plan", "Execute", "Blue ghosts", "Red and gray ghosts", "Proven"):
        assert word in text
    (link,) = re.findall('href="([^"]*)"', html)
    assert link.endswith("/docs")
    assert 'target="_blank"' in html
    # what it names is there to be pressed and chosen
    assert person.has("Plan")
    assert person.has("Execute")
    assert "drag the tool" in person.field("Goal").options


def test_the_help_is_the_last_tab(person):
    groups = {id(tab._parent): tab._parent for tab in containers(person).values()
              if hasattr(tab, "_parent")}  # fmt: skip
    (group,) = groups.values()
    assert list(group._tab_labels) == ["Plan", "Options", "Scene", "Plans", "?"]
