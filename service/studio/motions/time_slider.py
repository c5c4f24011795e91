"""TimeSlider: the time of a motion, from its start to an end that can change."""

from collections.abc import Callable
from typing import Any

import viser

_STEP = 0.001


class TimeSlider:
    """A slider that can be drawn anew with another end, in its place."""

    def __init__(self, gui: viser.GuiApi, end: float, on_seek: Callable[[], None]) -> None:
        """Show the start.

        Args:
            gui: Where it is shown, in the container that is open.
            end: Where it ends [s].
            on_seek: Called when the person at the browser chooses a time.
        """
        self._gui, self._on_seek = gui, on_seek
        self._place = gui.add_folder(None)
        self._slider: Any = None
        self._draw(end, 0.0)

    @property
    def value(self) -> float:
        """The time [s]."""
        return float(self._slider.value)

    @value.setter
    def value(self, time: float) -> None:
        self._slider.value = min(time, self._slider.max)

    def reach(self, end: float) -> None:
        """End at another time [s]; what is later than that is the end."""
        if round(end, 3) != self._slider.max:
            time = self.value
            self._slider.remove()
            self._draw(end, time)

    def _draw(self, end: float, time: float) -> None:
        last = round(end, 3)
        ends = ((0.0, "0"), (last, f"{last:.2f}"))  # short, for the page cuts the last one
        with self._place:
            self._slider = self._gui.add_slider(
                "Time [s]", 0.0, last, _STEP, min(time, last), marks=ends
            )
        self._slider.on_update(lambda event: self._on_seek() if event.client else None)
