"""The tool's path in colours: of clearance, or of the limit that binds."""

from html import escape

import numpy as np

from service.studio.motions.series import Series
from service.studio.numbers import Array
from service.studio.texts import spot

BY_CLEARANCE, BY_LIMIT = "clearance", "binding limit"
# Of clearance: red where something is as near as this [m], green beyond the other.
_NEAR, _FAR = 0.0, 0.05
_RED, _AMBER, _GREEN = np.array([230, 57, 70]), np.array([255, 183, 3]), np.array([42, 157, 143])
_UNBOUND = np.array([148, 163, 184])
_LIMITS = np.array([
    [29, 111, 184],
    [224, 122, 31],
    [122, 92, 199],
    [194, 50, 91],
    [140, 109, 70],
    [75, 85, 99],
])


def clearance_colors(clearance: Array) -> Array:
    """Return colours from red (touches) over amber to green (far), shape (n, 3)."""
    share = np.clip((clearance - _NEAR) / (_FAR - _NEAR), 0.0, 1.0)[:, None]
    low = _RED + (_AMBER - _RED) * np.minimum(1.0, 2 * share)
    return np.where(share < 0.5, low, _AMBER + (_GREEN - _AMBER) * (2 * share - 1))


def limit_colors(series: Series, times: Array) -> Array:
    """Return the colour of the limit that binds at some times, gray where none does, (n, 3)."""
    which, _ = series.binding()
    rows = np.searchsorted(series.times, times).clip(0, len(series.times) - 1)
    chosen = which[rows]
    return np.where((chosen < 0)[:, None], _UNBOUND, _LIMITS[chosen % len(_LIMITS)]).astype(float)


def legend(series: Series, kind: str) -> str:
    """Return what the colours mean, as HTML."""
    if kind == BY_CLEARANCE:
        steps = [(_RED, "0"), (_AMBER, "25 mm"), (_GREEN, "50 mm and more")]
    else:
        which, _ = series.binding()
        steps = [(_UNBOUND, "none")] if (which < 0).any() else []
        steps += [
            (_LIMITS[i % len(_LIMITS)], f"{series.limit_names[i]} {np.mean(which == i):.0%}")
            for i in np.unique(which[which >= 0])
        ]
    style = "white-space:nowrap;margin-right:0.8em"
    spots = "".join(
        f'<span style="{style}">{spot((r, g, b))}{escape(text)}</span>' for (r, g, b), text in steps
    )
    return f'<div style="padding:0 0.75em 0.3em;font-size:0.75em;color:#64748b">{spots}</div>'
