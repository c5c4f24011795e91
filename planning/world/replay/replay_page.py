"""labelled(): a Meshcat page with name labels and captions."""

import html
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Literal


@dataclass(frozen=True)
class Label:
    """Name label at an object's place.

    Attributes:
        path: Of the named object, in Meshcat's tree.
        text: The name.
        kind: Its kind; links are labelled on request only.
    """

    path: str
    text: str
    kind: Literal["thing", "frame", "link"]


@dataclass(frozen=True)
class Section:
    """Section of the animation with a caption.

    Attributes:
        title: Its caption.
        end: Its end in the animation [s].
    """

    title: str
    end: float


@dataclass(frozen=True)
class Track:
    """Curve of the plot under the slider.

    Attributes:
        name: Of the coordinate.
        times: In the animation [s].
        values: At these times [rad or m].
    """

    name: str
    times: list[float]
    values: list[float]


def labelled(
    page: str,
    title: str,
    labels: list[Label],
    sections: Sequence[Section] = (),
    tracks: Sequence[Track] = (),
    notes: Sequence[str] = (),
) -> str:
    """Return a page of Meshcat's `StaticHtml` with a title, names, captions, a slider and a plot.

    Args:
        page: It defines `viewer` and `MeshCat.THREE`.
        title: Of the page.
        labels: Name labels.
        sections: Of the animation, in order; none of a page without one.
        tracks: Curves to plot under the slider.
        notes: Lines of text under the title.
    """
    content = {
        "title": title,
        "labels": [asdict(label) for label in labels],
        "sections": [asdict(section) for section in sections],
        "tracks": [asdict(track) for track in tracks],
        "notes": list(notes),
    }
    # Escape names, so that none can end the script that contains it.
    encoded = json.dumps(content).replace("<", "\\u003c")
    head, _, rest = page.partition("<title>Drake MeshCat</title>")
    body, closing, tail = rest.rpartition("</body>")
    script = _script().replace("/*DATA*/ null", encoded)
    return f"{head}<title>{html.escape(title)}</title>{body}{script}\n{closing}{tail}"


@cache
def _script() -> str:
    return Path(__file__).with_name("replay_overlay.html").read_text(encoding="utf-8")
