"""Plans, goals and motions one after another: what is left of the one before, and what is not."""

import re

import numpy as np
import pytest

from tests.service.servers import until
from tests.service.studio.unseen import plain, studio


@pytest.fixture
def person(real_server):
    with studio(real_server.url) as opened:
        opened.click("Plan")
        opened.reads("^Proven")
        yield opened


def test_a_plan_while_the_robot_rests_is_carried_out_once_that_has_ended(person):
    person.set("Speed [x plan]", 0.1)
    person.start("Execute")
    person.reads("^plan 1: executing .* tracking error [0-9.]+ mrad$")
    person.click("Pause")
    person.reads("^plan 1: paused")
    person.click("Plan")
    person.reads("^Proven")
    assert not person.field("Execute").visible
    assert person.field("Resume").visible
    person.click("Stop")
    person.reads("^canceled")
    until(lambda: not person.field("Execute").disabled)
    assert person.field("Execute").visible
    assert person.field("Stop").disabled


def test_another_goal_takes_away_what_was_said_of_a_motion_that_is_over(person):
    person.click("Execute")
    person.reads("^arrived")
    person.set("Goal", "configuration stowed")
    until(lambda: not any(plain(line).startswith(("arrived", "Proven")) for line in person.says))
    assert person.field("Execute").disabled


def test_a_motion_to_the_goal_before_is_said_to_be_that(person):
    assert person.folder("Motion")
    until(lambda: person.field("Time [s]").value > 0)
    person.set("Goal", "configuration stowed")
    assert person.folder("Motion, to the goal before")
    assert person.field("Time [s]").value == 0
    assert not person.field("Execute").disabled


def test_what_is_said_of_a_plan_is_of_the_one_that_is_looked_at(person):
    first = person.reads("^planned in")
    person.set("Goal", "configuration stowed")
    person.click("Plan")
    second = until(lambda: [line for line in person.says if is_other(line, first)])[0]
    assert links(first) != links(second)
    until(lambda: person.field("Look at").value == "plan 2")
    person.set("Look at", "plan 1")
    until(lambda: first in person.says)
    assert 'title="' in first


def test_the_nearest_is_taken_by_the_handle_that_is_dragged(person):
    person.set("Goal", "drag the tool")
    gizmo = person.gizmo("/gizmo")
    assert np.linalg.norm(gizmo.position) > 0.1  # it begins where the tool is
    person.drag(gizmo, (0.5, 0.2, -0.02))
    person.reads("^The goal collides")
    until(lambda: person.field("Take the nearest").visible)
    person.click("Take the nearest")
    assert person.field("Goal").value == "drag the tool"
    assert gizmo.position[2] > -0.02
    person.reads(r"arm poses? reach(es)? it")


def links(line):
    return re.findall('href="([^"]*)"', line)


def is_other(line, first):
    return plain(line).startswith("planned in") and line != first
