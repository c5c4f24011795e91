"""labelled(): a page of Meshcat's with names in it, and with what is going on."""

import html
import json
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Literal


@dataclass(frozen=True)
class Label:
    """A name at something's place.

    Attributes:
        path: Of what is named, in Meshcat's tree.
        text: The name.
        kind: Of what; links are named on request only.
    """

    path: str
    text: str
    kind: Literal["thing", "frame", "link"]


@dataclass(frozen=True)
class Section:
    """A part of the animation.

    Attributes:
        title: What goes on in it.
        end: When it ends in the animation [s].
    """

    title: str
    end: float


def labelled(page: str, title: str, labels: list[Label], sections: list[Section]) -> str:
    """Return a page of Meshcat's `StaticHtml` with a title, names and a caption.

    Args:
        page: It defines `viewer` and `MeshCat.THREE`.
        title: Of the page.
        labels: What is named.
        sections: Of the animation, in order.
    """
    told = {
        "title": title,
        "labels": [asdict(label) for label in labels],
        "sections": [asdict(section) for section in sections],
    }
    # No name may end the script that it stands in.
    data = json.dumps(told).replace("<", "\\u003c")
    head, _, rest = page.partition("<title>Drake MeshCat</title>")
    body, closing, tail = rest.rpartition("</body>")
    script = _script().replace("/*DATA*/ null", data)
    return f"{head}<title>{html.escape(title)}</title>{body}{script}\n{closing}{tail}"


@cache
def _script() -> str:
    return Path(__file__).with_name("replay_overlay.html").read_text(encoding="utf-8")
