"""What the panels say, as HTML: everything that comes from a server is escaped."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

_GRAY, _GREEN, _RED, _BLUE = "#64748b", "#2a9d8f", "#e63946", "#1d6fb8"
_COLORS = {"plain": _GRAY, "good": _GREEN, "bad": _RED, "busy": _BLUE}
# Of buttons that nothing hangs on: red, green, blue.
SOFT = (226, 232, 240)
_BOX = "padding:0 0.75em 0.4em;font-size:0.8125em;line-height:1.45;overflow-wrap:anywhere"
# Of what is shown of a text of the server.
_MAX_TEXT = 600


def told(text: str, kind: str = "plain") -> str:
    """Return a line in the colour of its kind: plain, good, bad or busy."""
    style = f"{_BOX};color:{_COLORS[kind]}"
    return f'<div style="{style}" data-kind="{kind}">{escape(text[:_MAX_TEXT])}</div>'


def spot(color: tuple[float, float, float]) -> str:
    """Return a round spot in a colour: red, green, blue, 0 to 255."""
    red, green, blue = (round(part) for part in color)
    return (
        '<span style="display:inline-block;width:0.7em;height:0.7em;border-radius:50%;'
        f'margin-right:0.3em;background:rgb({red},{green},{blue})"></span>'
    )


def boxed(html: str) -> str:
    """Return HTML of one's own, with nothing of a server in it that is not escaped."""
    return f'<div style="{_BOX}">{html}</div>'


def failure(code: str, detail: str) -> str:
    """Return why something failed: its code and the words."""
    return (
        f'<div style="{_BOX};color:{_RED}" data-kind="bad"><b>{escape(code)}</b><br>'
        f"{escape(detail[:_MAX_TEXT])}</div>"
    )


def pages(server: str, plan: str, names: Mapping[str, str]) -> str:
    """Return links to pages of a plan, each in a tab of its own.

    Args:
        server: URL of the server as the browser knows it; empty for that of the page.
        plan: Its id.
        names: Of the pages, and what they are called.
    """
    links = " · ".join(
        f'<a href="{escape(server)}/v1/plans/{escape(plan)}/{escape(name)}" target="_blank" '
        f'rel="noopener" style="color:{_BLUE}">{escape(text)}</a>'
        for name, text in names.items()
    )
    return boxed(links)


def verdict(certificate: Mapping[str, Any], duration: float) -> str:
    """Return what is proven of a motion, in one line."""
    proven = bool(certificate["proven"])
    head = "Proven" if proven else "Not proven"
    gap = certificate["min_clearance"]
    apart = "nothing to hit" if gap is None else f"{1000 * gap:.1f} mm clear"
    pair = "" if gap is None else " of " + " and ".join(map(short, certificate["pair"]))
    color = _GREEN if proven else _RED
    return (
        f'<div style="{_BOX}" data-kind="{"good" if proven else "bad"}">'
        f'<b style="color:{color};font-size:1.1em">{head}</b> · {duration:.2f} s · '
        f'{escape(apart)}<span style="color:{_GRAY}">{escape(pair)}</span></div>'
    )


def pairs(found: Sequence[Mapping[str, Any]]) -> str:
    """Return which pairs collide, the deepest first."""
    deepest = sorted(found, key=lambda pair: -pair["depth"])[:4]
    rows = "".join(
        f"<br>{escape(short(a))} – {escape(short(b))}: {1000 * pair['depth']:.1f} mm"  # noqa: RUF001
        for pair in deepest
        for a, b in [pair["bodies"]]
    )
    return f'<div style="{_BOX};color:{_RED}" data-kind="bad"><b>Collides</b>{rows}</div>'


def short(name: str) -> str:
    """Return a name without the robot's."""
    return name.rpartition("::")[2]
