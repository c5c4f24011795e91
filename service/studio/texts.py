"""What the panels say, as HTML: everything that comes from a server is escaped."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

_GRAY, _GREEN, _RED, _BLUE, _AMBER = "#64748b", "#1f7a70", "#d62839", "#1d6fb8", "#b45309"
COLORS = {"plain": _GRAY, "good": _GREEN, "bad": _RED, "busy": _BLUE, "warn": _AMBER}
# Of buttons that nothing hangs on: red, green, blue.
SOFT = (226, 232, 240)
_BOX = "padding:0 0.75em 0.4em;font-size:0.8125em;line-height:1.45;overflow-wrap:anywhere"
# Of what is shown of a text of the server.
_MAX_TEXT = 600


def told(text: str, kind: str = "plain") -> str:
    """Return a line in the colour of its kind: plain, good, bad, busy or warn."""
    return lines(escape(text[:_MAX_TEXT]), kind)


def lines(html: str, kind: str) -> str:
    """Return HTML of one's own in the colour of its kind; what a server says in it is escaped."""
    return f'<div style="{_BOX};color:{COLORS[kind]}" data-kind="{kind}">{html}</div>'


def folded(head: str, rest: str) -> str:
    """Return a heading that opens a text when it is clicked, small and gray."""
    return (
        f'<details style="color:{_GRAY};font-size:0.9em"><summary style="cursor:pointer">'
        f"{escape(head)}</summary>{escape(rest[:_MAX_TEXT])}</details>"
    )


def millimetres(length: float) -> str:
    """Return a length [m] in millimetres, with digits enough to tell a small one from none."""
    value = 1000 * length
    if abs(value) >= 1 or value == 0:
        return f"{value:.1f} mm"
    return "below 0.001 mm" if 0 < value < 1e-3 else f"{float(f'{value:.2g}'):.5g} mm"


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


def pairs(found: Sequence[Mapping[str, Any]]) -> str:
    """Return which pairs collide, the deepest first."""
    deepest = sorted(found, key=lambda pair: -pair["depth"])[:4]
    rows = "".join(
        f"<br>{escape(short(a))} – {escape(short(b))}: {millimetres(pair['depth'])}"  # noqa: RUF001
        for pair in deepest
        for a, b in [pair["bodies"]]
    )
    return lines(f"<b>Collides</b>{rows}", "bad")


def short(name: str) -> str:
    """Return a name without the robot's."""
    return name.rpartition("::")[2]
