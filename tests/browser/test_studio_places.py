"""What only a page can show: buttons stay, emptied numbers come back, ghosts move side by side."""

import pytest

from tests.browser.studio_page import StudioPage
from tests.profiles import only_campaign
from tests.service.servers import until

pytestmark = [
    only_campaign("half a minute each without a graphics card"),
    pytest.mark.campaign,
    pytest.mark.timeout(900),
]
# Beside the panel, of a page that is a thousand pixels wide.
_WIDTH_OF_SCENE = 590
IN_PLACE_OF = {"Cancel": "Plan", "Pause": "Execute", "Resume": "Execute"}
EMPTYINGS = [("Delete",), ("Delete", "-"), ("Delete", "."), ("Delete", "3", "Backspace")]


def places(studio):
    """How far below the first field the buttons are [pixels], by whose place each takes.

    To click what is further below, the panel is scrolled.
    """
    found = {}
    top = studio.page.get_by_role("combobox", name="Scene", exact=True).last.bounding_box()["y"]
    for name in ("Plan", "Cancel", "Execute", "Pause", "Resume", "Stop"):
        button = studio.page.get_by_role("button", name=name, exact=True)
        if button.count():
            box = button.last.bounding_box()
            found[IN_PLACE_OF.get(name, name)] = round(box["y"] - top), round(box["height"])
    return found


def num_orange(picture):
    """How many pixels beside the panel have the colour of the first plan."""
    red, green, blue = (picture[:, :_WIDTH_OF_SCENE, i] for i in range(3))
    return ((red - blue > 40) & (red - green > 10) & (green - blue > 10)).sum()


def newest_plan(server):
    (brief, *_) = server.ask("GET", "/v1/plans")["items"]
    return server.ask("GET", f"/v1/plans/{brief['id']}")


def test_buttons_stay_where_they_are_whatever_is_said(browser, studio_server):
    # wide: in a narrow page the panel stands on the lower edge and grows upwards
    with StudioPage.opened(browser, studio_server.url, 1000, 600) as studio:
        studio.wait_for_goal()
        first = places(studio)
        assert {*first} == {"Plan", "Execute", "Stop"}
        studio.unfold("Joints of the goal")
        studio.set("shoulder_lift_joint", 0.5)
        studio.wait_for("Collides")
        assert places(studio) == first
        studio.click("Plan")
        studio.wait_for("goal_in_collision")
        assert places(studio) == first
        studio.click("Go to the nearest that is free")
        studio.wait_for("Proven")
        assert places(studio) == first
        studio.set("Speed [x plan]", 0.1)
        studio.click("Execute")
        studio.wait_for("executing")
        assert places(studio) == first
        studio.click("Stop")
        studio.wait_for("canceled")
        assert places(studio) == first


def test_a_number_that_was_emptied_is_shown_again_and_is_what_is_asked(studio, studio_server):
    studio.page.get_by_role("tab", name="Options").click()
    studio.unfold("Search")
    field = studio._number("Allowed planning time [s]")
    studio.set("Allowed planning time [s]", 7)
    for keys in EMPTYINGS:
        field.press("Control+A")
        for key in keys:
            field.press(key)
        assert not field.input_value().strip("-.")
        field.press("Tab")
        until(lambda: field.input_value() == "7")
    field.press("Control+A")
    field.press("Delete")
    # no field that is left: the button takes what is shown once it is pressed
    studio.page.get_by_role("tab", name="Plan", exact=True).click()
    studio.click("Plan")
    studio.wait_for("Proven")
    assert newest_plan(studio_server)["request"]["search"]["allowed_planning_time"] == 7
    assert studio._number("Allowed planning time [s]").input_value() == "7"


def test_a_plan_that_is_ticked_moves_beside_the_one_that_is_looked_at(browser, studio_server):
    with StudioPage.opened(browser, studio_server.url, 1000, 480) as page:
        page.wait_for_goal()
        page.click("Plan")
        page.wait_for("Proven")
        page.choose("Goal", "configuration stowed")
        page.wait_for("free")
        page.click("Plan")
        page.wait_for("Proven")
        page.wait_until_played()
        tabs = page.page.get_by_role("tab", name="Plans")
        tabs.click()
        alone = num_orange(page.settled_picture())
        tick = page.page.get_by_role("checkbox", name="plan 1", exact=True)
        tick.check()
        page.page.get_by_role("tab", name="Plan", exact=True).click()
        page.wait_until_played()
        tabs.click()
        assert num_orange(page.settled_picture()) > alone + 500  # at the end of the first plan
        tick.uncheck()
        until(lambda: num_orange(page.picture()) < alone + 50)
