"""labelled(): a Meshcat page with name labels and captions."""

import html
import json
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


def labelled(page: str, title: str, labels: list[Label], sections: list[Section]) -> str:
    """Return a page of Meshcat's `StaticHtml` with a title, names and a caption.

    Args:
        page: It defines `viewer` and `MeshCat.THREE`.
        title: Of the page.
        labels: Name labels.
        sections: Of the animation, in order.
    """
    content = {
        "title": title,
        "labels": [asdict(label) for label in labels],
        "sections": [asdict(section) for section in sections],
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
