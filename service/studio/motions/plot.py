"""A plot of curves over time, with a cursor at one time."""

import threading
from typing import Any

import numpy as np
import viser

from service.studio.motions.series import Curves
from service.studio.numbers import Array

_MAX_CURVES = 8
_COLORS = ("#1d6fb8", "#e07a1f", "#2a9d8f", "#c2325b", "#7a5cc7", "#8c6d46", "#4b5563", "#b5a21b")
_CURSOR = "#0f172a"
_HEIGHT = 190


class Plot:
    """Curves over time."""

    def __init__(
        self, gui: viser.GuiApi, folder: viser.GuiFolderHandle, times: Array, curves: Curves
    ) -> None:
        """Show curves at the time 0.

        Args:
            gui: Of one browser.
            folder: Where they are shown.
            times: Of the rows [s], shape (n,).
            curves: as many as have colours are shown.
        """
        self._gui, self._folder, self._time = gui, folder, 0.0
        self._lock = threading.Lock()
        self._plot: Any = None
        self.draw(times, curves)

    def draw(self, times: Array, curves: Curves) -> None:
        """Show other curves at the same time."""
        with self._lock:
            self._times, self._curves = times, curves
            order = None
            if self._plot is not None:
                # Columns and series cannot be changed together: the page hangs between the two.
                order = self._plot.order
                self._plot.remove()
            with self._folder:
                self._plot = self._gui.add_uplot(
                    with_cursor(times, self._rows, self._time),
                    self._series,
                    height=_HEIGHT,
                    scales={"x": {"time": False}, "now": {"range": (0.0, 1.0)}},
                    order=order,
                )

    def move_cursor(self, time: float) -> None:
        """Put the cursor to a time [s]."""
        with self._lock:
            self._time = time
            self._plot.data = with_cursor(self._times, self._rows, time)

    @property
    def _rows(self) -> Array:
        return self._curves.rows[:, :_MAX_CURVES]

    @property
    def _series(self) -> tuple[Any, ...]:
        names = self._curves.names[:_MAX_CURVES]
        return (
            {"label": "t [s]"},
            *(
                {"label": name, "stroke": color, "width": 2}
                for name, color in zip(names, _COLORS, strict=False)
            ),
            {"label": "now", "stroke": _CURSOR, "width": 1, "scale": "now"},
        )


def with_cursor(times: Array, rows: Array, time: float) -> tuple[Array, ...]:
    """Return columns of a plot: times, curves, and a line from 0 to 1 and back at one time.

    Args:
        times: Increasing [s], shape (n,).
        rows: Of the curves, finite, shape (n, curves).
        time: Of the line [s].
    """
    i = int(np.searchsorted(times, time))
    curves = [
        np.insert(column, i, [float(np.interp(time, times, column))] * 3) for column in rows.T
    ]
    return (
        np.insert(times, i, [time] * 3),
        *curves,
        np.insert(np.zeros(len(times)), i, [0.0, 1.0, 0.0]),
    )
