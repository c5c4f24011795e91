"""Working with the studio in Chromium: drag, fill in, fail, hurry, and not alone."""

import re

import httpx
import numpy as np
import pytest
import trimesh

from planning import bundled_folder
from tests.browser.studio_page import StudioPage, differs
from tests.profiles import only_campaign
from tests.service.servers import PLAIN, until

pytestmark = [
    only_campaign("half a minute each without a graphics card"),
    pytest.mark.campaign,
    pytest.mark.timeout(900),  # two pages, each drawn by a busy processor
]

# Beside the panel, of a page that is a thousand pixels wide.
_WIDTH_OF_SCENE = 590
BUNDLED = sorted(p.name.split(".")[0] for p in bundled_folder("scenes").glob("*.scene.yaml"))


def newest(server, kind):
    """The newest job of a kind, in full."""
    (brief, *_) = server.ask("GET", f"/v1/{kind}")["items"]
    return server.ask("GET", f"/v1/{kind}/{brief['id']}")


def running(server):
    """Plans that are at work now."""
    return server.ask("GET", "/v1/plans?state=running")["items"]


def own_scene(server):
    """The scene that the newest browser has opened."""
    return server.ask("GET", "/v1/scenes")["items"][0]["id"]


def share(other, server, scene):
    """Have a second browser look at the scene of the first one."""
    other.wait_for_goal()
    copy = own_scene(server)
    assert copy != scene
    other.choose("Scene", f"ur5e_pickup · {scene}")
    until(lambda: copy not in {item["id"] for item in server.ask("GET", "/v1/scenes")["items"]})
    other.wait_for_goal()


def is_reddish(picture):
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    return (red > 150) & (red - green > 60) & (red - blue > 60)


def red_in_scene(page):
    return is_reddish(page.settled_picture()[:, :_WIDTH_OF_SCENE]).sum()


def is_purple(picture):
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    return (blue - green > 50) & (blue - red > 40) & (red - green > 10)


def test_the_tool_is_dragged_to_a_goal(browser, studio_server):
    with StudioPage.opened(browser, studio_server.url, 1000, 480) as page:
        page.wait_for_goal()
        page.choose("Goal", "configuration home")  # the ghost stands where the robot is
        page.wait_for("free")
        before = page.settled_picture()
        page.choose("Goal", "drag the tool")
        page.wait_for(re.compile("arm poses? reach"))
        after = page.settled_picture()
        # its arrow along x is pink, and reaches furthest
        is_arrow = differs(after, before) & (after[..., 0] - after[..., 1] > 100)
        points = np.argwhere(is_arrow[:, :_WIDTH_OF_SCENE])[:, ::-1]
        assert len(points) > 20
        middle = np.median(points, axis=0)
        tip = points[np.argmax(np.linalg.norm(points - middle, axis=1))]
        start = tip + 0.2 * (middle - tip)
        end = start + 0.5 * (tip - middle)
        scene = own_scene(studio_server)
        group = studio_server.ask("GET", f"/v1/scenes/{scene}")["groups"][0]
        body = {
            "group": group["name"],
            "configurations": [group["positions"]],
            "frames": group["tool_frames"][:1],
        }
        (row,) = studio_server.ask("POST", f"/v1/scenes/{scene}/fk", body)["results"]
        (tool,) = row.values()
        # what is under the mouse is lit: before that nothing can be grasped
        page.page.mouse.move(*start)
        until(lambda: differs(page.picture(), after).any())
        lit = page.settled_picture()
        # drawn without a graphics card, a page may miss that it is grabbed: then it is again
        for _ in range(3):
            page.drag(start, end)
            if differs(page.settled_picture(), lit).sum() > 500:
                break
        page.click("Plan")
        page.page.get_by_text(re.compile("Proven|goal_|no_path")).first.wait_for()
        goal = newest(studio_server, "plans")["request"]["goal"]
        assert goal["type"] == "pose"
        moved = np.subtract(goal["poses"][0]["position"], tool["position"])
        assert 0.005 < np.linalg.norm(moved) < 1.0


def test_options_that_are_filled_in_are_asked(studio, studio_server):
    tab = studio.page.get_by_role("tab", name="Options")
    tab.click()
    studio.unfold("Search")
    studio.choose("Planner", "RRTstar")
    studio.set("Allowed planning time [s]", 2)
    studio.page.get_by_role("checkbox", name="Keep graph").check()
    studio.unfold("Retime")
    studio.set("Velocity scale", 0.5)
    studio.wait_for("otherwise than by default")
    studio.page.get_by_role("tab", name="Plan", exact=True).click()
    before = is_purple(studio.settled_picture()).sum()
    studio.click("Plan")
    studio.wait_for("Proven")
    # the way among what was explored is drawn
    until(lambda: is_purple(studio.picture()).sum() > before + 30)
    request = newest(studio_server, "plans")["request"]
    assert request["search"]["planner"] == "RRTstar"
    assert request["search"]["allowed_planning_time"] == 2
    assert request["search"]["keep_graph"] is True
    assert request["retime"]["velocity_scale"] == 0.5
    tab.click()
    studio.click("Back to the defaults")
    studio.wait_for("all by default")


def test_the_best_path_so_far_is_drawn_until_the_plan_has_ended(browser, studio_server):
    with StudioPage.opened(browser, studio_server.url, 1000, 480) as page:
        page.wait_for_goal()
        # a way that takes a search, and a planner that improves each of a hundred
        page.choose("Scene", "maze_2d")
        page.wait_for_scene("maze_2d")
        page.page.get_by_role("tab", name="Options").click()
        page.unfold("Search")
        page.choose("Planner", "RRTstar")
        page.set("Attempts", 100)
        page.set("Allowed planning time [s]", 600)
        page.page.get_by_role("tab", name="Plan", exact=True).click()
        before = is_purple(page.settled_picture()).sum()
        page.click("Plan")
        page.wait_for("the best path so far is")
        (found,) = [plan for plan in running(studio_server) if plan["best"] is not None]
        assert len(found["best"]["waypoints"]) > 1
        until(lambda: is_purple(page.picture()).sum() > before + 30)
        page.click("Cancel")
        page.wait_for("canceled")
        until(lambda: is_purple(page.picture()).sum() <= before + 5)


def test_a_failed_plan_is_red_where_it_fails_and_has_a_picture(browser, studio_server):
    # wide: the panel would cover what is red
    with StudioPage.opened(browser, studio_server.url, 1000, 600) as studio:
        studio.wait_for_goal()
        studio.unfold("Joints of the goal")
        studio.wait_for("mm clear there")
        free = red_in_scene(studio)
        studio.set("shoulder_lift_joint", 0.5)
        studio.wait_for("Collides")
        studio.click("Plan")
        studio.wait_for("goal_in_collision")
        assert red_in_scene(studio) > free + 500
        with studio.page.expect_popup() as opened:
            studio.page.get_by_role("link", name="picture of the failure").click()
        opened.value.get_by_text("goal_in_collision").first.wait_for()
        assert opened.value.locator("canvas").count() > 0


def test_a_motion_is_made_slower_while_it_goes_on(studio, studio_server):
    studio.click("Plan")
    studio.wait_for("Proven")
    studio.set("Speed [x plan]", 0.2)
    studio.click("Execute")
    studio.wait_for("executing")
    studio.set("Speed [x plan]", 0.1)
    until(
        lambda: newest(studio_server, "executions")["status"]["path_velocity"] == pytest.approx(0.1)
    )
    studio.set("Speed [x plan]", 3)
    studio.wait_for("arrived")
    assert newest(studio_server, "executions")["state"] == "succeeded"


def test_two_browsers_see_the_same_robot_move(studio, browser, studio_server):
    scene = own_scene(studio_server)
    with StudioPage.opened(browser, studio_server.url) as other:
        share(other, studio_server, scene)
        still = other.settled_picture()
        studio.click("Plan")
        studio.wait_for("Proven")
        studio.click("Execute")
        studio.wait_for("arrived")
        # nothing was clicked there
        until(lambda: differs(other.picture(), still).sum() > 300)


def test_two_browsers_see_each_others_edits(studio, browser, studio_server):
    scene = own_scene(studio_server)
    with StudioPage.opened(browser, studio_server.url) as other:
        share(other, studio_server, scene)
        studio.page.get_by_role("tab", name="Scene").click()
        studio.click("sphere")
        studio.wait_for("revision 2: add sphere_1")
        other.page.get_by_role("tab", name="Scene").click()
        until(lambda: "sphere_1" in other.options("Object"))


def test_one_browser_carries_out_what_another_has_planned(studio, browser, studio_server):
    scene = own_scene(studio_server)
    studio.click("Plan")
    studio.wait_for("Proven")
    with StudioPage.opened(browser, studio_server.url) as other:
        share(other, studio_server, scene)
        other.page.get_by_role("tab", name="Plans").click()
        other.choose("Look at", "plan 1")
        other.page.get_by_role("tab", name="Plan", exact=True).click()
        other.wait_for("Proven")
        other.click("Execute")
        other.wait_for("arrived")
    ended = newest(studio_server, "executions")
    assert ended["state"] == "succeeded"
    plans = httpx.get(f"{studio_server.url}/v1/plans", params={"scene": scene}, **PLAIN).json()
    assert [plan["id"] for plan in plans["items"]] == [ended["request"]["plan"]]


@pytest.mark.parametrize("name", BUNDLED)
def test_three_clicks_lead_to_a_moving_robot_in_each_bundled_scene(name, studio, studio_server):
    # which one, how, and go: the list is opened to choose from, which is no decision
    if name != "ur5e_pickup":
        studio.choose("Scene", name)
        studio.wait_for_scene(name)
    studio.click("Plan")
    studio.wait_for("Proven")
    studio.click("Execute")
    studio.wait_for("arrived")
    ended = newest(studio_server, "executions")
    assert ended["state"] == "succeeded"
    scene = studio_server.ask("GET", f"/v1/scenes/{ended['scene']}")
    assert scene["name"] == name
    moved = newest(studio_server, "plans")["result"]["trajectory"]["positions"]
    assert np.abs(np.subtract(moved[-1], moved[0])).max() > 0.01


@pytest.mark.parametrize("name", ["part.stl", "part.obj"])
def test_a_file_that_is_added_is_in_the_way(name, studio, studio_server, tmp_path):
    scene = own_scene(studio_server)
    mesh = trimesh.creation.torus(120.0, 30.0)
    mesh.apply_translation([500.0, 300.0, 120.0])  # above the can, where the hand is to be
    file = tmp_path / name
    mesh.export(file)
    studio.page.get_by_role("tab", name="Scene").click()
    studio.choose("Unit of files", "millimetres")
    with studio.page.expect_file_chooser() as chooser:
        studio.click("Add an STL or OBJ file")
    chooser.value.set_files(file)
    studio.wait_for("revision 2: add part_1")
    document = studio_server.ask("GET", f"/v1/scenes/{scene}")["document"]
    (entry,) = [entry for entry in document["objects"] if entry["name"] == "part_1"]
    corners = np.array(entry["shape"]["convex"]["points"])
    np.testing.assert_allclose(np.ptp(corners, axis=0), [0.3, 0.3, 0.06], atol=1e-4)
    studio.page.get_by_role("tab", name="Plan", exact=True).click()
    studio.page.locator("[data-kind=bad]").first.wait_for()
    studio.click("Plan")
    studio.page.get_by_text("goal_").first.wait_for()
