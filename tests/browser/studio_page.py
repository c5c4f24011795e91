"""The studio as a person sees it: what stands there, and what can be clicked."""

import io
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from PIL import Image

# For what hangs: on a busy machine without a graphics card the page takes its time [ms].
_PATIENCE = 90_000
# Small, for every pixel is drawn by the processor.
_SIZE = {"width": 480, "height": 600}


class StudioPage:
    """A page of the studio."""

    def __init__(self, page):
        self.page = page
        self.faults = []
        self.faults_are_expected = False
        page.set_default_timeout(_PATIENCE)
        page.on("pageerror", lambda fault: self.faults.append(str(fault)))
        page.on("console", self._note)

    @classmethod
    @contextmanager
    def opened(cls, browser, url, width=_SIZE["width"], height=_SIZE["height"]):
        size = {"width": width, "height": height}
        context = browser.new_context(locale="en-US", viewport=size)
        try:
            page = cls(context.new_page())
            page.page.goto(url)
            yield page
            assert page.faults_are_expected or page.faults == [], page.faults
        finally:
            context.close()

    def wait_for_goal(self):
        """Wait until the scene is there and its goal was looked at."""
        self.page.locator("[data-kind=good], [data-kind=bad]").first.wait_for()

    def wait_for(self, text):
        """Wait for a text; if it does not come, say what stands there instead."""
        from playwright.sync_api import TimeoutError as WaitedInVain

        try:
            self.page.get_by_text(text).first.wait_for()
        except WaitedInVain:
            told = [line.inner_text() for line in self.page.locator("[data-kind]").all()]
            pytest.fail(f"{text!r} does not come; the page says {told}")

    def click(self, button):
        self.page.get_by_role("button", name=button, exact=True).last.click()

    def choose(self, label, option):
        """Choose an option of a list; one that closes while others are drawn is opened again."""
        from playwright.sync_api import TimeoutError as WaitedInVain

        box = self.page.get_by_role("combobox", name=label, exact=True).last
        for _ in range(5):
            box.click()
            with suppress(WaitedInVain):
                self.page.get_by_role("option", name=option, exact=True).click(timeout=15_000)
                return
            box.press("Escape")
        pytest.fail(f"{option!r} of {label!r} cannot be chosen")

    def options(self, label):
        """What can be chosen from a list."""
        box = self.page.get_by_role("combobox", name=label, exact=True).last
        box.click()
        self.page.get_by_role("option").first.wait_for()
        found = [option.inner_text() for option in self.page.get_by_role("option").all()]
        box.press("Escape")
        return found

    def set(self, slider, value):
        """Set a slider by the number beside it."""
        number = self._number(slider)
        number.fill(str(value))
        number.press("Enter")

    def value(self, slider):
        """What a slider says."""
        return float(self._number(slider).input_value())

    def picture(self):
        """What is drawn, shape (height, width, 3), without the panel and what lies over it."""
        shot = self.page.screenshot(mask=[self.page.get_by_role("alert")], mask_color="#ffffff")
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)

    def settled_picture(self):
        """What is drawn once it moves no more."""
        before = self.picture()
        while (differs(now := self.picture(), before)).any():
            before = now
        return now

    def drag(self, start, end):
        """Drag with the mouse from one pixel to another, (x, y)."""
        mouse = self.page.mouse
        mouse.move(*start)
        mouse.down()
        for share in (0.25, 0.5, 0.75, 1.0):
            mouse.move(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))
        mouse.up()

    def wait_until_played(self):
        """Wait until a motion that was planned has been played once."""
        while self.value("Time [s]") < self.longest("Time [s]") - 1e-3:
            self.page.wait_for_timeout(100)
        self.page.get_by_role("button", name="Play", exact=True).wait_for()

    def longest(self, slider):
        """The upper end of a slider."""
        row = self._number(slider).locator("xpath=ancestor::*[.//*[@role='slider']][1]")
        return float(row.locator("[role=slider]").get_attribute("aria-valuemax"))

    def wait_for_scene(self, name):
        """Wait until a scene that was chosen is there, with its goal."""
        box = self.page.get_by_role("combobox", name="Scene", exact=True).last
        while box.input_value() != name:
            self.page.wait_for_timeout(50)
        self.wait_for_goal()

    def hide_notices(self):
        """Hide what stands in the corner: that nothing here has a graphics card."""
        self.page.add_style_tag(content=".mantine-Notification-root { display: none }")

    def unfold(self, folder):
        self.page.get_by_text(folder, exact=True).first.click()

    def sees(self, text):
        return self.page.get_by_text(text).count() > 0

    def _number(self, slider):
        label = self.page.get_by_text(slider, exact=True)
        row = label.locator("xpath=ancestor::*[.//input[not(@type='hidden')]][1]")
        return row.locator("input:not([type=hidden])").last

    def _note(self, message):
        if message.type == "error":
            self.faults.append(message.text)


def differs(one, other):
    """Which pixels of two pictures are clearly different, shape (height, width)."""
    return np.abs(one - other).max(axis=2) > 24
