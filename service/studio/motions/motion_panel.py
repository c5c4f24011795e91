"""MotionPanel: a planned motion: play, time slider, curves, the tool's trace, certificate."""

import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from service.studio import texts
from service.studio.api import Array
from service.studio.cell import Cell
from service.studio.motion import Motion, clearance_colors

# Of pictures [1/s], which a browser without a graphics card still draws.
_RATE = 24.0
_PLOT_HEIGHT = 170
_MAX_CURVES = 8
_COLORS = ("#1d6fb8", "#e07a1f", "#2a9d8f", "#c2325b", "#7a5cc7", "#8c6d46", "#4b5563", "#b5a21b")
_TRACE = np.array([251, 133, 0])
# Instants at which the clearance is looked at, for the colours of the trace and its curve.
_NUM_LOOKS = 80
_LOOK: dict[str, Any] = {"height": _PLOT_HEIGHT, "scales": {"x": {"time": False}}}


class MotionPanel:
    """A motion, shown by the ghost."""

    def __init__(
        self, gui: viser.GuiApi, cell: Cell, motion: Motion, on_fault: Callable[[Exception], None]
    ) -> None:
        """Show a motion, and play it once.

        Args:
            gui: Where it is shown, in the container that is open.
            cell: The scene.
            motion: Planned in it.
            on_fault: Is told what goes wrong.
        """
        self.motion = motion
        self._cell, self._on_fault = cell, on_fault
        self._stop = threading.Event()
        self._stop.set()
        gui.add_html(texts.verdict(motion.certificate, motion.duration))
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        step = max(motion.duration / 1000, 1e-6)
        self._slider = gui.add_slider("Time [s]", 0.0, motion.duration, step, 0.0)
        self._play.on_click(lambda _: self.toggle())
        self._slider.on_update(lambda event: self._seek() if event.client else None)
        self._kind = gui.add_dropdown("Curves", ("position", "velocity", "clearance"))
        self._plot = gui.add_uplot(*_curves(motion.times, motion.positions, motion.names), **_LOOK)
        self._kind.on_update(lambda _: self._draw_curves())
        self._clearance: tuple[Array, Array] | None = None
        self._draw_trace()
        threading.Thread(target=self._look, daemon=True).start()
        self.toggle()

    def toggle(self) -> None:
        """Play from where it is, or from the start if it is at the end; or stop."""
        if not self._stop.is_set():
            self._stop.set()
            return
        self._stop.clear()
        self._play.label, self._play.icon = "Pause", viser.Icon.PLAYER_PAUSE
        threading.Thread(target=self._run, daemon=True).start()

    def close(self) -> None:
        """Stop to play."""
        self._stop.set()

    def _run(self) -> None:
        time, end = self._slider.value, self.motion.duration
        time = 0.0 if time >= end - 1.0 / _RATE else time
        while not self._stop.wait(1.0 / _RATE) and time < end:
            time = min(end, time + 1.0 / _RATE)
            self._slider.value = time
            self._show(time)
        self._stop.set()
        self._play.label, self._play.icon = "Play", viser.Icon.PLAYER_PLAY

    def _seek(self) -> None:
        self._stop.set()
        self._show(self._slider.value)

    def _show(self, time: float) -> None:
        self._cell.view.show_ghost(self.motion.at(time))

    def _look(self) -> None:
        """Look at the clearance along the motion, and colour the trace by it."""
        cell, motion = self._cell, self.motion
        rows = np.unique(np.linspace(0, len(motion.times) - 1, _NUM_LOOKS).astype(int))
        try:
            verdicts = cell.api.check(cell.scene.id, cell.group.name, motion.positions[rows])
        except Exception as fault:  # noqa: BLE001  (told to the person at the browser)
            self._on_fault(fault)
            return
        found = np.array([v["distance"] if v["distance"] is not None else np.inf for v in verdicts])
        self._clearance = motion.times[rows], found
        self._draw_trace()
        if self._kind.value == "clearance":
            self._draw_curves()

    def _draw_trace(self) -> None:
        tool = self.motion.tool
        if tool is None:
            return
        colors = np.tile(_TRACE, (len(tool), 1))
        if self._clearance is not None:
            colors = clearance_colors(np.interp(self.motion.times, *self._clearance))
        self._cell.view.draw_trace("plan", tool, colors)

    def _draw_curves(self) -> None:
        motion, kind = self.motion, self._kind.value
        if kind == "clearance":
            times, found = self._clearance or (motion.times[[0, -1]], np.full(2, np.nan))
            rows = np.where(np.isfinite(found), 1000 * found, np.nan)[:, None]
            data, series = _curves(times, rows, ["clearance [mm]"])
        else:
            rows = motion.positions if kind == "position" else motion.velocities
            data, series = _curves(motion.times, rows, motion.names)
        self._plot.data, self._plot.series = data, series


def _curves(times: Array, rows: Array, names: Sequence[str]) -> tuple[Any, Any]:
    """Return data and series of a plot, at most as many curves as have colours."""
    count = min(rows.shape[1], _MAX_CURVES)
    labels = [names[i] if i < len(names) else str(i) for i in range(count)]
    series = [{"label": "t [s]"}] + [
        {"label": label, "stroke": _COLORS[i], "width": 2} for i, label in enumerate(labels)
    ]
    return (times, *(np.ascontiguousarray(rows[:, i]) for i in range(count))), tuple(series)
