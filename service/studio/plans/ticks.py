"""PlanTicks: a tick for each plan of the table, for the motions that are played side by side."""

from collections.abc import Callable, Mapping
from typing import Any

import viser

from service.studio import texts


class PlanTicks:
    """Which plans are shown beside the one that is looked at."""

    def __init__(
        self, gui: viser.GuiApi, on_change: Callable[[], None], on_play: Callable[[], None]
    ) -> None:
        """Show no plan yet.

        Args:
            gui: Where they are shown, in the container that is open.
            on_change: Called when the person at the browser ticks others.
            on_play: Called when the motions are to be played again.
        """
        self._gui, self._on_change = gui, on_change
        self._folder = gui.add_folder("Side by side", visible=False)
        with self._folder:
            self._told = gui.add_html(
                texts.told("Each plan that is ticked has a ghost in its colour.")
            )
            self._play = gui.add_button(
                "Play side by side",
                icon=viser.Icon.PLAYER_PLAY,
                color=texts.SOFT,
                disabled=True,
                hint="From the start, with the plan that is looked at; each ends at its own end",
            )
        self._play.on_click(lambda _: on_play())
        self._ticks: dict[str, Any] = {}

    @property
    def ticked(self) -> list[str]:
        """Ids of the plans that are ticked, the oldest first."""
        return [plan for plan, tick in self._ticks.items() if tick.value]

    def renew(self, names: Mapping[str, str]) -> None:
        """Show plans, by their ids: what they are called, the oldest first; no others remain."""
        before = self.ticked
        for plan in [plan for plan in self._ticks if plan not in names]:
            self._ticks.pop(plan).remove()
        with self._folder:
            for plan, name in names.items():
                if plan not in self._ticks:
                    tick = self._gui.add_checkbox(name, initial_value=False)
                    tick.on_update(lambda event: self._note() if event.client else None)
                    self._ticks[plan] = tick
        self._folder.visible = len(names) > 1
        if self.ticked != before:
            self._note()

    def _note(self) -> None:
        self._play.disabled = not self.ticked
        self._on_change()
