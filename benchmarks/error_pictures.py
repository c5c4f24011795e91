"""Take a picture of each kind of failure that has a place: `benchmarks/error_pictures.py`.

A private server plans what cannot be planned, and a headless Chromium opens the `failure.html` of
each. The pages of the codes (`docs/site/error_pages.py`) show what lies in `docs/images/errors`.
"""

import argparse
import io
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from benchmarks.page_pictures import screenshot  # noqa: E402
from service.cli.private_server import private_server  # noqa: E402
from service.client.client import Client  # noqa: E402
from tests.browser.chromium import chromium  # noqa: E402

_QUALITY = 80
_IN_BOX = [0, -0.5, 1.2, -2.2, -1.57, 0]
_BEYOND = [6.5, -1.57, 1.57, -1.57, -1.57, 0]
_ABOVE_CAN = [0.310, -1.226, 1.824, -2.169, -1.571, -1.261]
_READY = {"type": "configuration", "name": "ready"}
_PICK: dict[str, Any] = {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "pick"}]}
_AROUND_CAN = {"size": [0.2, 0.2, 0.3], "pose": {"position": [0.5, 0.3, 0.1]}}


def _keep_out(box: dict[str, Any]) -> list[dict[str, Any]]:
    return [{"type": "keep_out", "frame": "arm::tcp", "box": box}]


# What `ur5e_pickup` cannot be asked for, by the code of the answer.
REQUESTS: dict[str, dict[str, Any]] = {
    "start_in_collision": {"start": _IN_BOX, "goal": _READY},
    "start_too_near": {"goal": _READY, "margin": 0.09},
    "start_out_of_limits": {"start": _BEYOND, "goal": _READY},
    "start_violates_constraint": {
        "goal": _READY,
        "path_constraints": _keep_out({"size": [2, 2, 2]}),
    },
    "goal_out_of_limits": {"goal": {"type": "joint", "positions": _BEYOND}},
    "goal_in_collision": {"goal": {"type": "joint", "positions": _IN_BOX}},
    "goal_too_near": {"goal": {"type": "joint", "positions": _ABOVE_CAN}, "margin": 0.02},
    "goal_unreachable": {"goal": {"type": "pose", "poses": [{"position": [0.6, 0.8, 0.8]}]}},
    "goal_violates_constraint": {"goal": _PICK, "path_constraints": _keep_out(_AROUND_CAN)},
    "approach_blocked": {"goal": {**_PICK, "approach": [0, 0, 0.3]}},
    "line_blocked": {
        "goal": {"type": "line", "displacement": {"vector": [0, 0, -0.6], "frame": "world"}}
    },
    "not_certified": {"goal": _PICK, "certify": {"max_stopping_time": 0.001}},
}
# How `maze_2d` is searched whose only way is closed, by the code of the answer.
CLOSED: dict[str, dict[str, Any]] = {
    "no_path_found": {"allowed_planning_time": 20.0, "solve_time": 0.5},
    "deadline_exceeded": {"allowed_planning_time": 1.0},
}
_DOOR = {
    "name": "door",
    "shape": {"box": [0.3, 0.02, 0.06]},
    "pose": {"position": [-0.37, -0.18, 0.03]},
}


def main() -> None:
    """Ask, open and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    folder_ = ROOT / "docs" / "images" / "errors"
    parser.add_argument("--folder", type=Path, default=folder_)
    folder: Path = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as pages, private_server() as client, chromium() as browser:
        for code, html in _failures(client):
            begun = time.monotonic()
            page = Path(pages) / f"{code}.html"
            page.write_text(html, encoding="utf-8")
            picture = _small(screenshot(browser, page))
            (folder / f"{code}.webp").write_bytes(picture)
            print(f"{code}.webp: {len(picture) // 1024} kB, {time.monotonic() - begun:.0f} s")


def _failures(client: Client) -> Iterator[tuple[str, str]]:
    """Yield code and page of each failure.

    Raises:
        RuntimeError: A request ends in another way.
    """
    pickup = _posted(client, "ur5e_pickup")
    for code, request in REQUESTS.items():
        yield code, _page(client, code, {"scene": pickup, "group": "arm", **request})
    maze = _posted(client, "maze_2d")
    client.edit_scene(maze, {"revision": 1, "operations": [{"op": "add", "object": _DOOR}]})
    through = {"scene": maze, "group": "body", "goal": {"type": "configuration", "name": "exit"}}
    for code, search in CLOSED.items():
        request = {**through, "search": {"approximate": True, **search}}
        yield code, _page(client, code, request)


def _posted(client: Client, name: str) -> str:
    text = (ROOT / "scenes" / f"{name}.scene.yaml").read_bytes()
    return client.create_scene(text, media_type="application/yaml").id


def _page(client: Client, code: str, request: dict[str, Any]) -> str:
    plan = client.create_plan({"seed": 7, **request}, wait=60)
    found = plan.state if plan.failure is None else plan.failure.code
    if found != code:
        message = f"{code}: the request ended as {found}"
        raise RuntimeError(message)
    return client.get_failure_view(plan.id)


def _small(png: bytes) -> bytes:
    """Return a picture as WebP."""
    written = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").save(written, "WEBP", quality=_QUALITY, method=6)
    return written.getvalue()


if __name__ == "__main__":
    main()
