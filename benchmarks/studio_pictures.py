"""Take pictures of the studio: `benchmarks/studio_pictures.py [--folder F] [--only NAME ...]`.

A private server, and a headless Chromium that clicks as a person would: a proven motion, its
checks, the options, a failure, the objects of a scene, and every bundled scene after three clicks.
"""

import argparse
import io
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from service.cli.private_server import private_server  # noqa: E402
from tests.browser.chromium import chromium  # noqa: E402
from tests.browser.studio_page import StudioPage  # noqa: E402

_SIZE = (1180, 760)
# Of a bundled scene in the sheet of all, which has so many a row.
_SMALL, _COLUMNS = (590, 380), 3
_COLOURS = 256


def proven(page: StudioPage) -> None:
    """Plan, and stand in the middle of the motion."""
    page.click("Plan")
    page.wait_for("Proven")
    page.wait_until_played()
    page.set("Time [s]", 0.6)


def checks(page: StudioPage) -> None:
    """Look at what was checked, and where it is nearest."""
    proven(page)
    page.page.get_by_text(" checks").first.click()
    page.page.get_by_role("button", name=" mm at ").first.click()


def options(page: StudioPage) -> None:
    """Fill in what a plan may be asked."""
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
    page.unfold("Joints of the goal")
    page.set("shoulder_lift_joint", 0.4)
    page.wait_for("Collides")
    page.unfold("Joints of the goal")
    page.click("Plan")
    page.wait_for("Ask instead")


def scene(page: StudioPage) -> None:
    """Add an object, and show margins."""
    page.page.get_by_role("tab", name="Scene").click()
    page.click("box")
    page.wait_for("revision 2")


_STORIES: dict[str, Callable[[StudioPage], None]] = {
    "studio": proven,
    "studio_checks": checks,
    "studio_options": options,
    "studio_failure": failure,
    "studio_scene": scene,
}
_SHEET = "studio_scenes"


def main() -> None:
    """Open, click and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "docs" / "images")
    parser.add_argument("--only", nargs="*", default=[*_STORIES, _SHEET])
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    with private_server() as client, chromium() as browser:
        for name in arguments.only:
            begun = time.monotonic()
            if name == _SHEET:
                picture = _sheet(browser, client.url)
            else:
                with StudioPage.opened(browser, client.url, *_SIZE) as page:
                    page.wait_for_goal()
                    _STORIES[name](page)
                    picture = _shot(page)
            written = _png(picture)
            (arguments.folder / f"{name}.png").write_bytes(written)
            print(f"{name}.png: {len(written) // 1024} kB, {time.monotonic() - begun:.0f} s")


def _sheet(browser: Any, url: str) -> Image.Image:
    """Return all bundled scenes, each with a proven motion."""
    names = sorted(path.name.split(".")[0] for path in (ROOT / "scenes").glob("*.scene.yaml"))
    shots = list[Image.Image]()
    for name in names:
        with StudioPage.opened(browser, url, *_SIZE) as page:
            page.wait_for_goal()
            page.choose("Scene", name)
            page.wait_for_scene(name)
            proven(page)
            shots.append(_shot(page).resize(_SMALL, Image.Resampling.LANCZOS))
    rows = -(-len(shots) // _COLUMNS)
    sheet = Image.new("RGB", (_COLUMNS * _SMALL[0], rows * _SMALL[1]), "white")
    for i, shot in enumerate(shots):
        sheet.paste(shot, (i % _COLUMNS * _SMALL[0], i // _COLUMNS * _SMALL[1]))
    return sheet


def _shot(page: StudioPage) -> Image.Image:
    page.hide_notices()
    page.settled_picture()
    return Image.open(io.BytesIO(page.page.screenshot())).convert("RGB")


def _png(picture: Image.Image) -> bytes:
    written = io.BytesIO()
    few = picture.quantize(_COLOURS, dither=Image.Dither.NONE)
    few.save(written, "PNG", optimize=True)
    return written.getvalue()


if __name__ == "__main__":
    main()
