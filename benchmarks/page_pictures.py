"""Take pictures of a server's pages: `benchmarks/page_pictures.py [--folder docs/images]`.

A private server plans in the bundled scene `ur5e_pickup`, and a headless Chromium opens what it
answers: the scene, the replay with its slider and plot, a failure, the report.
"""

import argparse
import io
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from service.cli.private_server import private_server  # noqa: E402
from service.client.client import Client  # noqa: E402
from tests.browser.chromium import chromium  # noqa: E402

_SIZE = {"width": 960, "height": 600}
# As many as a picture needs; each halves the file where it is fewer.
_COLOURS = 256
# Frames of Meshcat after which everything stands where it should.
_FRAMES = 12
_PATIENCE = 120_000
_SEEK = """(share) => {
  const slider = document.getElementById("wp-slider");
  slider.value = share * slider.max;
  slider.oninput();
}"""
_DRAWN = """(count) => new Promise((done) => {
  const next = () => { if (count-- > 0) { requestAnimationFrame(next); } else { done(); } };
  next();
})"""


def main() -> None:
    """Plan, open and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "docs" / "images")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as pages, private_server() as client, chromium() as browser:
        for name, html, prepare in _pages(client):
            begun = time.monotonic()
            file = Path(pages) / f"{name}.html"
            file.write_text(html, encoding="utf-8")
            picture = _few_colours(screenshot(browser, file, prepare))
            (folder / f"page_{name}.png").write_bytes(picture)
            print(f"page_{name}.png: {len(picture) // 1024} kB, {time.monotonic() - begun:.0f} s")


def _pages(client: Client) -> Iterator[tuple[str, str, Callable[[Any], None] | None]]:
    """Yield the name of each page, its text, and what is done before it is taken."""
    text = (ROOT / "scenes" / "ur5e_pickup.scene.yaml").read_bytes()
    scene = client.create_scene(text, media_type="application/yaml").id
    goals = {
        "good": {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]},
        "bad": {"type": "joint", "positions": [0, -0.5, 1.2, -2.2, -1.57, 0]},  # in the box
    }
    plans = {
        name: client.create_plan({"scene": scene, "group": "arm", "goal": goal, "seed": 7}, wait=60)
        for name, goal in goals.items()
    }
    yield "view", client.get_scene_view(scene), None
    yield "replay", client.get_replay(plans["good"].id), _half_way
    yield "failure", client.get_failure_view(plans["bad"].id), None
    yield "report", client.get_plan_report(plans["good"].id), None


def _half_way(page: Any) -> None:
    page.click("#wp-plots")
    page.evaluate(_SEEK, 0.5)


def screenshot(browser: Any, file: Path, prepare: Callable[[Any], None] | None = None) -> bytes:
    """Return a PNG of a page once it is drawn, without Meshcat's menu."""
    context = browser.new_context(locale="en-US", viewport=_SIZE)
    try:
        page = context.new_page()
        page.set_default_timeout(_PATIENCE)
        page.goto(file.as_uri())
        page.add_style_tag(content=".dg .close-button { display: none; }")
        page.evaluate(_DRAWN, _FRAMES)
        if prepare is not None:
            prepare(page)
            page.evaluate(_DRAWN, _FRAMES)
        shot: bytes = page.screenshot()
        return shot
    finally:
        context.close()


def _few_colours(png: bytes) -> bytes:
    shot = Image.open(io.BytesIO(png)).convert("RGB")
    written = io.BytesIO()
    shot.quantize(_COLOURS, dither=Image.Dither.NONE).save(written, "PNG", optimize=True)
    return written.getvalue()


if __name__ == "__main__":
    main()
