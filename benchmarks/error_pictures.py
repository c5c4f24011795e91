"""Have each failure happen that can, for its page in the guide: `benchmarks/error_pictures.py`.

Private servers are asked for what cannot be done, or are disturbed. Of each failure the answer is
recorded as an example (`docs/site/error_examples.json`), and of one that has a place a headless
Chromium takes a picture (`docs/images/errors`), which the pages of the codes show.
"""

import argparse
import io
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from PIL import Image  # noqa: E402

from benchmarks.error_runs.asking import Asking  # noqa: E402
from benchmarks.error_runs.cameras import aimed  # noqa: E402
from benchmarks.error_runs.commands import commands  # noqa: E402
from benchmarks.error_runs.grasps import grasps  # noqa: E402
from benchmarks.error_runs.guarded import guarded  # noqa: E402
from benchmarks.error_runs.jobs import jobs  # noqa: E402
from benchmarks.error_runs.loads import loads  # noqa: E402
from benchmarks.error_runs.made import Made, Page, Printed  # noqa: E402
from benchmarks.error_runs.motions import motions  # noqa: E402
from benchmarks.error_runs.plans import plans  # noqa: E402
from benchmarks.page_pictures import screenshot  # noqa: E402
from service.cli.private_server import private_server  # noqa: E402
from tests.browser.chromium import chromium  # noqa: E402
from tests.golden.error_examples import record  # noqa: E402

_QUALITY = 80
# What is seen, all of it on one server with settings that cause none of it.
_SEEN: dict[str, Callable[[Asking], Iterator[Made]]] = {
    "plans": plans,
    "motions": motions,
    "loads": loads,
    "grasps": grasps,
}
# What words alone tell of, each with servers or data folders of its own.
_TOLD: dict[str, Callable[[], Iterator[Made] | Iterator[Printed]]] = {
    "jobs": jobs,
    "guarded": guarded,
    "commands": commands,
}


def main() -> None:
    """Have them happen, take pictures and record examples."""
    parser = argparse.ArgumentParser(description=__doc__)
    folder = ROOT / "docs" / "images" / "errors"
    parser.add_argument("--folder", type=Path, default=folder)
    parser.add_argument("kinds", nargs="*", help=f"of {[*_SEEN, *_TOLD]}; by default all")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    chosen: list[str] = options.kinds or [*_SEEN, *_TOLD]
    examples: dict[str, dict[str, Any]] = {}
    seen = [_SEEN[kind] for kind in chosen if kind in _SEEN]
    for made in _seen(seen, options.folder) if seen else ():
        examples[made.code] = made.example
    for kind in chosen:
        for told in _TOLD[kind]() if kind in _TOLD else ():
            examples[told.code] = told.example
            print(told.code)
    record(examples, {str(ROOT): "."})


def _seen(kinds: Sequence[Callable[[Asking], Iterator[Made]]], folder: Path) -> Iterator[Made]:
    """Yield what happens on one server, with a picture of each of which there is a page."""
    with private_server() as client, chromium() as browser, TemporaryDirectory() as pages:
        asking = Asking(client.url)
        for made in (each for kind in kinds for each in kind(asking)):
            if made.page is not None:
                begun = time.monotonic()
                picture = _picture(browser, made.page(), Path(pages) / f"{made.code}.html")
                (folder / f"{made.code}.webp").write_bytes(picture)
                seconds = time.monotonic() - begun
                print(f"{made.code}.webp: {len(picture) // 1024} kB, {seconds:.0f} s")
            yield made


def _picture(browser: Any, page: Page, file: Path) -> bytes:
    """Return a picture of a page as WebP."""
    file.write_text(page.html, encoding="utf-8")
    shot = screenshot(browser, file, None if page.camera is None else aimed(page.camera))
    written = io.BytesIO()
    Image.open(io.BytesIO(shot)).convert("RGB").save(written, "WEBP", quality=_QUALITY, method=6)
    return written.getvalue()


if __name__ == "__main__":
    main()
