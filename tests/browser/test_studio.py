"""The studio in Chromium: from opening the page to a moving robot, and what can go wrong."""

import re

import httpx
import pytest
import yaml

from tests.browser.studio_page import StudioPage
from tests.profiles import only_campaign
from tests.service.servers import PLAIN, until


def executions(server):
    return httpx.get(f"{server.url}/v1/executions", **PLAIN).json()["items"]


def test_two_clicks_lead_from_the_open_page_to_a_robot_that_has_moved(studio, studio_server):
    before = {job["id"] for job in executions(studio_server)}
    studio.click("Plan")
    studio.wait_for("Proven")
    studio.click("Execute")
    studio.wait_for("arrived")
    (job,) = [job for job in executions(studio_server) if job["id"] not in before]
    assert job["state"] == "succeeded"
    assert studio.page.title() == "Wayproof studio"


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_a_check_leads_to_its_time_and_curves_follow(studio):
    studio.click("Plan")
    studio.wait_for("Proven")
    until(lambda: studio.value("Time [s]") > 0.9)  # it was played
    studio.unfold("10 checks")
    studio.page.get_by_role("button", name=" mm at 0.9").click()
    studio.wait_for("bound 0 m, right_finger")
    until(lambda: 0.9 < studio.value("Time [s]") < 0.99)
    studio.choose("Path colour", "binding limit")
    studio.wait_for(re.compile(r"acceleration \d+%"))
    studio.choose("Curves", "torque")
    studio.page.locator(".u-legend").get_by_text("wrist_3_joint").wait_for()


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_another_way_to_reach_the_goal_is_planned_to(studio, studio_server):
    ways = studio.options("Arm pose")
    assert len(ways) > 1
    assert "wrist" in ways[0]
    studio.choose("Arm pose", ways[1])
    studio.click("Plan")
    studio.wait_for("Proven")
    plans = httpx.get(f"{studio_server.url}/v1/plans", **PLAIN).json()["items"]
    assert plans[0]["request"]["goal"]["type"] == "joint"


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_a_motion_is_paused_goes_on_and_is_stopped(studio, studio_server):
    studio.click("Plan")
    studio.wait_for("Proven")
    studio.set("Speed [x plan]", 0.1)
    studio.click("Execute")
    studio.wait_for("executing")
    studio.click("Pause")
    studio.click("Resume")
    studio.wait_for("executing")
    studio.click("Stop")
    studio.wait_for("canceled")
    assert any(job["state"] == "canceled" for job in executions(studio_server))


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_a_goal_in_collision_is_red_with_its_pair_and_the_plan_says_why(studio):
    # straight up at the second joint, the arm goes through its table
    studio.page.get_by_text("Joints of the goal").click()
    studio.set("shoulder_lift_joint", 0.5)
    studio.wait_for("Collides")
    studio.click("Plan")
    studio.wait_for("goal_in_collision")
    # what would do is offered, and does
    studio.click("Go to the nearest that is free")
    studio.wait_for("Proven")
    assert not studio.sees("Ask instead")


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_another_scene_is_shown_planned_in_and_its_own(studio, browser, studio_server):
    studio.choose("Scene", "maze_2d")
    with StudioPage.opened(browser, studio_server.url) as other:
        other.wait_for_goal()
        other.click("Plan")
        other.wait_for("right_finger and can")
        studio.click("Plan")
        studio.wait_for("Proven")
        assert not studio.sees("right_finger")
        assert not other.sees("nothing to hit")


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_scenes_of_a_browser_that_left_are_forgotten(browser, studio_server):
    def names():
        items = httpx.get(f"{studio_server.url}/v1/scenes", **PLAIN).json()["items"]
        return {item["id"] for item in items}

    before = names()
    with StudioPage.opened(browser, studio_server.url) as page:
        page.wait_for_goal()
        (own,) = names() - before
    until(lambda: own not in names())


@only_campaign("half a minute without a graphics card")
@pytest.mark.campaign
def test_a_scene_is_edited_undone_and_saved(studio, studio_server):
    def newest():
        (brief, *_) = httpx.get(f"{studio_server.url}/v1/scenes", **PLAIN).json()["items"]
        return httpx.get(f"{studio_server.url}/v1/scenes/{brief['id']}", **PLAIN).json()

    studio.page.get_by_role("tab", name="Scene").click()
    studio.click("box")
    studio.wait_for("revision 2: add box_1")
    studio.set("Side z [m]", 0.3)
    studio.wait_for("revision 3: resize box_1")
    with studio.page.expect_download() as download:
        studio.click("Save as YAML")
    saved = yaml.safe_load(download.value.path().read_text())
    (box,) = [entry for entry in saved["objects"] if entry["name"] == "box_1"]
    assert box["shape"]["box"] == [0.1, 0.1, 0.3]
    assert newest()["document"] == saved
    studio.click("Delete")
    studio.wait_for("revision 4: remove box_1")
    studio.click("Undo")
    studio.wait_for("revision 5: undo: remove box_1")
    assert newest()["document"] == saved
    assert studio_server.client.add_scene(yaml.safe_dump(saved)).name == "ur5e_pickup"
