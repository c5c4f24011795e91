"""Charts of a motion against its limits, drawn with matplotlib."""

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from planning.api.motion_series import MotionSeries
from planning.domain.arrays import Array

# Text stays text, and the same motion gives the same bytes.
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "wayproof",
    "font.size": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
}
_LINE, _LIMIT, _FAINT, _OTHER = "#1f4e79", "#b03a2e", "#7f8c8d", "#b9770e"
_WIDTH, _ROW, _MARGIN = 7.0, 0.95, 0.9
# Of a legend: its height by entry [in], and how long a name may be. Ten colours take turns.
_ENTRY, _LONGEST = 0.19, 40
_STROKES = ("-", "--", "-.", ":")


def draw(name: str, series: MotionSeries) -> str:
    """Return a chart as SVG.

    Args:
        name: One of `CHARTS`.
        series: What to draw.
    """
    with rc_context(_STYLE):
        figure = Figure(layout="constrained")
        FigureCanvasSVG(figure)
        CHARTS[name](figure, series)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": "Wayproof"})
    return text.getvalue()


def _positions(figure: Figure, series: MotionSeries) -> None:
    limits = series.limits
    bounds = list(zip(limits.lower, limits.upper, strict=True))
    _rows(figure, series, series.group.position_names, series.positions, bounds)
    figure.suptitle("position and its limits [rad or m]")


def _velocity(figure: Figure, series: MotionSeries) -> None:
    bounds = _symmetric(series, series.limits.velocity)
    _rows(figure, series, series.group.velocity_names, series.derivatives[0], bounds)
    figure.suptitle("velocity and its limits [rad/s or m/s]")


def _acceleration(figure: Figure, series: MotionSeries) -> None:
    bounds = list(zip(*series.acceleration_range, strict=True))
    _rows(figure, series, series.group.velocity_names, series.derivatives[1], bounds)
    figure.suptitle("acceleration and its limits [rad/s² or m/s²]")


def _jerk(figure: Figure, series: MotionSeries) -> None:
    unit = "[rad/s³ or m/s³]"
    if series.is_jerk_limited:
        bounds = _symmetric(series, series.limits.jerk)
        _rows(figure, series, series.group.velocity_names, series.derivatives[2], bounds)
        figure.suptitle(f"jerk and its limits {unit}")
        return
    bounds = [(-np.inf, np.inf)] * series.derivatives.shape[2]
    rows = _rows(figure, series, series.group.velocity_names, series.derivatives[2], bounds)
    for axes in rows:
        axes.plot(
            series.acceleration_jumps,
            np.zeros_like(series.acceleration_jumps),
            "|",
            color=_LIMIT,
            markersize=6,
        )
    figure.suptitle(
        f"jerk between jumps {unit}: it was not limited (method toppra);\n"
        f"at the marks, {len(series.acceleration_jumps)}, acceleration jumps and jerk is infinite",
        fontsize=8,
    )


def _torque(figure: Figure, series: MotionSeries) -> None:
    bounds = _symmetric(series, series.limits.effort)
    _rows(figure, series, series.group.velocity_names, series.efforts, bounds)
    figure.suptitle("torque that the motion takes, and its limits [N m or N]")


def _clearance(figure: Figure, series: MotionSeries) -> None:
    figure.set_size_inches(_WIDTH, 3.0)
    axes = figure.subplots()
    axes.plot(series.times, 1000 * series.clearance, color=_LINE, label="smallest distance")
    axes.axhline(0.0, color=_LIMIT, linestyle="--", linewidth=0.8, label="contact")
    least = int(np.argmin(series.clearance))
    axes.plot(series.times[least], 1000 * series.clearance[least], "o", color=_LIMIT, markersize=4)
    if (series.signed_margin != series.clearance).any():
        margin = 1000 * series.margin
        axes.axhline(margin, color=_OTHER, linestyle=":", label=f"margin, {margin:.4g} mm")
        axes.plot(
            series.times,
            1000 * series.signed_margin,
            color=_OTHER,
            label="least to spare over margins",
        )
        figure.legend(loc="outside lower center", ncols=4, fontsize=7)
    between = " and ".join(series.closest_pairs[least]) or "all are farther apart"
    axes.set_title(
        f"smallest distance of any pair [mm]; least, {1000 * series.clearance[least]:.1f} mm at "
        f"{series.times[least]:.2f} s: {between}",
        fontsize=8,
    )
    axes.set_xlabel("time [s]")


def _tool_speed(figure: Figure, series: MotionSeries) -> None:
    limits = {limit.frame: limit.speed for limit in series.options.tool_limits}
    bounds = [(-np.inf, limits.get(frame) or np.inf) for frame in series.tool_speeds]
    if not bounds:
        figure.suptitle("the group has no tool frame, and none is limited")
        return
    speeds = np.stack(list(series.tool_speeds.values()), axis=1)
    _rows(figure, series, tuple(series.tool_speeds), speeds, bounds)
    figure.suptitle("speed of tool frames, and its limits [m/s]")


def _utilisation(figure: Figure, series: MotionSeries) -> None:
    used = {name: values.max(axis=1) for name, values in series.utilisation.items()}
    shown = {name: values for name, values in used.items() if np.isfinite(values).all()}
    figure.set_size_inches(_WIDTH, max(3.0, _ENTRY * (len(shown) + 2)))
    axes = figure.subplots()
    for i, (name, values) in enumerate(shown.items()):
        label = name if len(name) <= _LONGEST else f"{name[:_LONGEST]}..."
        axes.plot(series.times, values, label=label, linewidth=1.1, linestyle=_STROKES[i // 10 % 4])
    axes.axhline(1.0, color=_LIMIT, linestyle="--", linewidth=0.8)
    unlimited = "" if series.is_jerk_limited else "; jerk was not limited"
    axes.set_title(f"use of the limits, of the joint that uses most{unlimited}", fontsize=8)
    top = max([1.0, *(float(values.max()) for values in shown.values())])
    axes.set_ylim(0.0, 1.05 * top)
    axes.set_xlabel("time [s]")
    figure.legend(loc="outside right upper")


CHARTS: dict[str, Callable[[Figure, MotionSeries], None]] = {
    "acceleration": _acceleration,
    "clearance": _clearance,
    "jerk": _jerk,
    "position": _positions,
    "tool_speed": _tool_speed,
    "torque": _torque,
    "utilisation": _utilisation,
    "velocity": _velocity,
}
# Those that draw distances of bodies, which take longer to measure than a chart to draw.
OF_DISTANCES = frozenset({"clearance"})


def _symmetric(series: MotionSeries, bounds: Array) -> list[tuple[float, float]]:
    """Return a limit on the norm of a block as bounds of each of its coordinates."""
    by_column: dict[int, float] = {
        column: float(bound)
        for block, bound in zip(series.limits.blocks, bounds, strict=True)
        for column in block
    }
    return [(-by_column[i], by_column[i]) for i in sorted(by_column)]


def _rows(
    figure: Figure,
    series: MotionSeries,
    names: tuple[str, ...],
    values: Array,
    bounds: list[tuple[float, float]],
) -> list[Any]:
    """Draw a row for every coordinate, with its limits where they are finite; return the axes."""
    figure.set_size_inches(_WIDTH, _MARGIN + _ROW * len(names))
    rows = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name, column, limits in zip(rows, names, values.T, bounds, strict=True):
        axes.plot(series.times, column, color=_LINE, linewidth=1.1)
        for limit in limits:
            if np.isfinite(limit):
                axes.axhline(limit, color=_LIMIT, linestyle="--", linewidth=0.8)
        axes.set_ylabel(
            name.partition("::")[2] or name,
            rotation=0,
            horizontalalignment="right",
            color=_FAINT,
            fontsize=7,
        )
    rows[-1].set_xlabel("time [s]")
    return list(rows)
