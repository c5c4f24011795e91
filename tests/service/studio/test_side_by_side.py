"""Several plans at once: a ghost each, which moves with the time and stops at its own end."""

import threading

import numpy as np
import pytest

from service.studio.motions.motion_panel import MotionPanel
from service.studio.motions.shown_motion import ShownMotion
from tests.service.servers import until
from tests.service.studio.unseen import plain, studio

# The first of these plans is the shorter one; both begin where the robot is.
SLOWER = "configuration stowed"


@pytest.fixture
def person(real_server):
    with studio(real_server.url) as opened:
        opened.server = real_server
        opened.click("Plan")
        opened.reads("^Proven")
        until(lambda: opened.has("Velocity scale"))
        opened.reads("all by default")
        opened.set("Velocity scale", 0.3)
        opened.set("Goal", SLOWER)
        opened.click("Plan")
        until(lambda: opened.field("Look at").value == "plan 2")
        yield opened


def plans(person):
    """The plans of the table, the oldest first, in full."""
    items = person.server.ask("GET", "/v1/plans")["items"][:2]
    return [person.server.ask("GET", f"/v1/plans/{item['id']}") for item in reversed(items)]


def ghost(person, plan):
    """Where the nodes of a ghost beside are, by name."""
    nodes = [*person.browser.scene._handle_from_node_name.items()]
    path = f"/beside/{plan['id']}/"
    found = {name: node for name, node in nodes if name.startswith(path)}
    return {name: np.array(node.position) for name, node in found.items() if name.count("/") == 3}


def duration(plan):
    return plan["result"]["trajectory"]["times"][-1]


def origins(person, plan, row):
    """Where the frames of the robot are at a row of a motion, shape (n, 3)."""
    request = plan["request"]
    scene = person.server.ask("GET", f"/v1/scenes/{request['scene']}")
    body = {
        "group": request["group"],
        "configurations": [plan["result"]["trajectory"]["positions"][row]],
        "frames": [frame for frame in scene["frames"] if frame != "world"],
    }
    (found,) = person.server.ask("POST", f"/v1/scenes/{request['scene']}/fk", body)["results"]
    return np.array([pose["position"] for pose in found.values()])


def is_at(person, plan, row):
    """Whether all bodies of a ghost stand where the robot is at a row of its motion."""
    nodes, frames = ghost(person, plan), origins(person, plan, row)
    away = [np.linalg.norm(frames - place, axis=1).min() for place in nodes.values()]
    return len(away) > 3 and max(away) < 1e-4


def tick(person, label, *, is_on=True):
    person.set(label, is_on)


def test_one_plan_has_no_ghost_beside_and_no_longer_time(person):
    first, second = plans(person)
    assert ghost(person, first) == ghost(person, second) == {}
    assert person.field("Time [s]").max == pytest.approx(duration(second), abs=1e-3)
    assert person.field("Play side by side").disabled


def test_each_ghost_goes_along_its_own_motion_and_rests_at_its_own_end(person):
    first, second = plans(person)
    assert duration(first) < duration(second) - 0.1
    tick(person, "plan 1")
    until(lambda: person.field("Time [s]").value > 0 and ghost(person, first))
    person.set("Time [s]", 0.0)
    assert is_at(person, first, 0)
    person.set("Time [s]", duration(first) + 0.05)
    assert is_at(person, first, -1)
    assert not is_at(person, first, 0)
    person.set("Time [s]", duration(second))
    assert is_at(person, first, -1)
    assert ghost(person, second) == {}  # it is the ghost


def test_the_time_ends_with_the_longest_and_the_cursor_with_the_plan_that_is_looked_at(person):
    first, second = plans(person)
    person.set("Look at", "plan 1")
    until(lambda: person.field("Time [s]").max == pytest.approx(duration(first), abs=1e-3))
    tick(person, "plan 2")
    until(lambda: person.field("Time [s]").max == pytest.approx(duration(second), abs=1e-3))
    until(lambda: ghost(person, second))
    person.set("Time [s]", person.field("Time [s]").max)
    assert is_at(person, second, -1)
    (plot,) = curves(person)
    assert plot.data[0].max() == pytest.approx(duration(first))
    tick(person, "plan 2", is_on=False)
    until(lambda: not ghost(person, second))
    assert person.field("Time [s]").max == pytest.approx(duration(first), abs=1e-3)
    assert person.field("Time [s]").value <= person.field("Time [s]").max


def test_all_of_them_play_from_the_start_and_go_with_another_goal(person):
    first, _ = plans(person)
    tick(person, "plan 1")
    end = person.field("Time [s]").max
    until(lambda: person.field("Time [s]").value >= end - 1e-3)
    assert is_at(person, first, -1)
    person.click("Play side by side")
    until(lambda: 0 < person.field("Time [s]").value < end / 2)
    person.set("Goal", "configuration home")
    until(lambda: not ghost(person, first))
    person.click("Plan")  # what is ticked stays so
    until(lambda: person.field("Look at").value == "plan 3")
    until(lambda: ghost(person, first))
    assert person.notices == []


def test_ghosts_of_another_scene_are_gone(person):
    first, _ = plans(person)
    tick(person, "plan 1")
    until(lambda: ghost(person, first))
    person.set("Scene", "maze_2d")
    person.reads("nothing to hit|clear there|reach it")
    until(lambda: not ghost(person, first))
    assert not any("plan 1" in plain(line) for line in person.says)


def test_a_motion_that_is_about_to_play_is_closed_before_it_or_after(person, monkeypatch):
    toggle, close = MotionPanel.toggle, ShownMotion.close
    begun, closed = threading.Event(), threading.Event()

    def toggle_late(panel):
        begun.set()
        closed.wait(0.5)
        toggle(panel)

    def close_and_tell(shown):
        close(shown)
        closed.set()

    monkeypatch.setattr(MotionPanel, "toggle", toggle_late)
    monkeypatch.setattr(ShownMotion, "close", close_and_tell)
    tick(person, "plan 1")
    assert begun.wait(30)
    person.set("Scene", "maze_2d")
    person.reads("nothing to hit|clear there|reach it")  # a thread that fails meanwhile is an error
    assert person.notices == []


def curves(person):
    """The plots that stand there."""
    containers = [*person.browser.gui._container_handle_from_uuid.values()]
    children = [child for folder in containers for child in [*folder._children.values()]]
    return [child for child in children if hasattr(child, "series") and hasattr(child, "data")]


def test_a_plan_of_another_robot_moves_beside(real_server):
    with studio(real_server.url) as person:
        person.server = real_server
        person.set("Scene", "two_arms")
        until(lambda: "both" in person.field("Robot").options)
        person.reads("reach it|clear there")
        person.click("Plan")
        person.reads("^Proven")
        person.set("Robot", "both")
        until(
            lambda: any(name.startswith("configuration") for name in person.field("Goal").options)
        )
        goals = [name for name in person.field("Goal").options if name.startswith("configuration")]
        person.set("Goal", goals[0])
        person.reads("^free")
        person.click("Plan")
        until(lambda: person.field("Look at").value == "plan 2")
        first, _ = plans(person)
        tick(person, "plan 1")
        until(lambda: ghost(person, first))
        until(lambda: person.field("Time [s]").value >= person.field("Time [s]").max - 1e-3)
        until(lambda: is_at(person, first, -1))  # the ghost follows the time that is shown
        assert person.notices == []
        person.set("Look at", "plan 1")  # it is of the robot that was chosen before
        assert person.field("Look at").value == "plan 2"
        assert "is of left" in person.notices[0]
