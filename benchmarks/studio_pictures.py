"""Take pictures of the studio: `benchmarks/studio_pictures.py [--folder docs/images]`.

A private server, and a headless Chromium that clicks as a person would: a proven motion, its
checks, the options, a failure, and the objects of a scene.
"""

import argparse
import io
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from service.cli.private_server import private_server  # noqa: E402
from tests.browser.chromium import chromium  # noqa: E402
from tests.browser.studio_page import StudioPage  # noqa: E402

_SIZE = (1180, 760)
_COLOURS = 256
# Of the motion's time, where the ghost stands.
_MIDDLE = 0.6


def proven(page: StudioPage) -> None:
    """Plan, and stand in the middle of the motion."""
    page.click("Plan")
    page.wait_for("Proven")
    page.wait_until_played()
    page.set("Time [s]", round(_MIDDLE * page.longest("Time [s]"), 2))


def checks(page: StudioPage) -> None:
    """Look at what was checked, and where it is nearest."""
    page.page.get_by_text(" checks").first.click()
    page.page.get_by_role("button", name=" mm at ").first.click()


def options(page: StudioPage) -> None:
    """Fill in what a plan may be asked, and see what was explored."""
    page.page.get_by_role("tab", name="Options").click()
    page.unfold("Search")
    page.choose("Planner", "RRTstar")
    page.page.get_by_role("checkbox", name="Keep graph").check()
    page.set("Allowed planning time [s]", 2)
    page.page.get_by_role("tab", name="Plan", exact=True).click()
    proven(page)
    page.page.get_by_role("tab", name="Options").click()


def failure(page: StudioPage) -> None:
    """Ask for what collides."""
    page.page.get_by_role("tab", name="Plan", exact=True).click()
    page.unfold("Joints of the goal")
    page.set("shoulder_lift_joint", 0.5)
    page.wait_for("Collides")
    page.unfold("Joints of the goal")
    page.click("Plan")
    page.wait_for("Ask instead")


def scene(page: StudioPage) -> None:
    """Add an object."""
    page.page.get_by_role("tab", name="Scene").click()
    page.click("box")
    page.wait_for("revision 2")


# One after the other, each story in a page of its own.
_STORIES: tuple[dict[str, Callable[[StudioPage], None]], ...] = (
    {"studio_failure": failure},
    {"studio_scene": scene},
    {"studio": proven, "studio_checks": checks, "studio_options": options},
)


def main() -> None:
    """Open, click and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "docs" / "images")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    with private_server() as client, chromium() as browser:
        for name, picture in _pictures(browser, client.url):
            written = _png(picture)
            (folder / f"{name}.png").write_bytes(written)
            print(f"{name}.png: {len(written) // 1024} kB")


def _pictures(browser: Any, url: str) -> Iterator[tuple[str, Image.Image]]:
    for story in _STORIES:
        with StudioPage.opened(browser, url, *_SIZE) as page:
            page.wait_for_goal()
            page.hide_notices()
            for name, act in story.items():
                act(page)
                yield name, _shot(page)


def _shot(page: StudioPage) -> Image.Image:
    page.settled_picture()
    return Image.open(io.BytesIO(page.page.screenshot())).convert("RGB")


def _png(picture: Image.Image) -> bytes:
    written = io.BytesIO()
    few = picture.quantize(_COLOURS, kmeans=3, dither=Image.Dither.NONE)
    few.save(written, "PNG", optimize=True)
    return written.getvalue()


if __name__ == "__main__":
    main()
