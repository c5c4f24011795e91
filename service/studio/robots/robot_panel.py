"""RobotPanel: carry a plan out: start, pause, resume, stop, and change its speed."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import viser

from service.studio import texts
from service.studio.api import ShownGroup
from service.studio.cell import Cell
from service.studio.plans.failure_words import failed
from service.studio.robots.tracking import unit_of

# Of the way back, of the fastest way there, and between them.
_BACK, _FASTEST, _STEP = -1.0, 3.0, 0.1
_FINAL = {"succeeded", "canceled", "aborted"}
# Dark enough for white words.
_ORANGE, _RED = (194, 65, 12), (185, 28, 28)


class RobotPanel:
    """The buttons that move the robot, and where it is."""

    def __init__(
        self,
        gui: viser.GuiApi,
        bar: viser.GuiFolderHandle,
        said: viser.GuiFolderHandle,
        on_execute: Callable[[], None],
        on_fault: Callable[[Exception], None],
        name_of: Callable[[str], str],
    ) -> None:
        """Show the buttons.

        Args:
            gui: Of one browser.
            bar: Where the buttons stand, and stay.
            said: Where it is said how far the robot is.
            on_execute: Called when it is to begin.
            on_fault: Is told what goes wrong.
            name_of: Returns what a plan is called.
        """
        self._on_fault, self._name_of = on_fault, name_of
        with bar:
            self._add_buttons(gui)
        with said:
            self._bar = gui.add_progress_bar(0.0, color="orange", visible=False)
            self._told = gui.add_html(texts.told(""), visible=False)
        self._button.on_click(lambda _: on_execute())
        self._pause.on_click(lambda _: self._control("resume" if self._is_paused else "pause"))
        self._stop.on_click(lambda _: self._control("cancel"))
        self._speed.on_update(lambda event: self._set_speed() if event.client else None)
        self._is_paused = False
        self._offered: str | None = None
        self.carried_out: str | None = None
        self._running: tuple[Cell, str, str] | None = None
        self._lock = threading.Lock()

    def offer(self, plan: str | None, *, is_sure: bool = True) -> None:
        """Let a plan be carried out, once nothing moves; none to let nothing be.

        Args:
            plan: Its id.
            is_sure: Whether it is proven in the scene as it is: else the server looks first.
        """
        self._offered = plan
        self._button.color = _ORANGE if is_sure else texts.SOFT
        self._show_buttons()

    def execute(self, cell: Cell, plan: str) -> bool:
        """Carry a plan out, show the robot move, and return whether it arrived.

        Args:
            cell: The scene.
            plan: Its id.
        """
        if not self._lock.acquire(blocking=False):
            return False
        try:
            if self._speed.value <= 0:  # it begins at the start, from where no way leads back
                self._speed.value = 1.0
            execution = cell.api.execute(plan, self._speed.value)
            self._running = cell, execution.id, plan
            self.carried_out = plan
            self._show_buttons()
            for event in cell.api.execution_events(execution.id):
                if event.type == "status":
                    self._follow(event.data, plan, cell.group)
                elif event.type == "controls" and event.data.get("is_paused") is not None:
                    self._show_pause(is_paused=bool(event.data["is_paused"]))
            ended = cell.api.execution(execution.id)
            if ended.status is not None:
                cell.show(np.array(ended.status.positions))
            return self._ended(ended.state, ended.failure and ended.failure.detail)
        finally:
            self._running = None
            self._show_pause(is_paused=False)
            self._show_buttons()
            self._lock.release()

    def say_refused(self, detail: str, evidence: Mapping[str, Any]) -> None:
        """Say why the server does not carry a motion out."""
        self._tell(failed("not_certified", detail, evidence))

    def clear(self) -> None:
        """Say nothing, once the scene is another one; what moves is still told of."""
        if self._running is None:
            self._told.visible = False
        self.offer(None)

    def _add_buttons(self, gui: viser.GuiApi) -> None:
        self._button = gui.add_button(
            "Execute", icon=viser.Icon.ROBOT, color=_ORANGE, disabled=True
        )
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, color=_RED, disabled=True)
        self._speed = gui.add_slider(
            "Speed [x plan]",
            _BACK,
            _FASTEST,
            _STEP,
            1.0,
            disabled=True,
            hint="Of the robot: 1 as planned, 0 rests on the path, -1 goes back along it",
        )

    def _ended(self, state: str, detail: str | None) -> bool:
        is_there = state == "succeeded"
        text = "arrived" if is_there else f"{state}: {detail or ''}"
        self._tell(texts.told(text, "good" if is_there else "bad"))
        return is_there

    def _follow(self, data: Mapping[str, Any], plan: str, group: ShownGroup) -> None:
        progress, state = float(data["progress"]), str(data["state"])
        self._bar.value = 100.0 * progress
        self._show_pause(is_paused=state == "paused")
        if state not in _FINAL:
            off = 1000 * float(data.get("tracking_error") or 0.0)
            error = f"tracking error {off:.1f} {unit_of(group)}"
            text = f"{self._name_of(plan)}: {state} · {100 * progress:.0f} % · {error}"
            self._tell(texts.told(text, "busy"))

    def _control(self, what: str, **body: float) -> None:
        running = self._running
        if running is None:
            return
        cell, execution, _ = running
        try:
            cell.api.control(execution, what, **body)
        except Exception as fault:  # noqa: BLE001  (told to the person at the browser)
            self._on_fault(fault)

    def _set_speed(self) -> None:
        self._control("speed", speed=float(self._speed.value))

    def _show_pause(self, *, is_paused: bool) -> None:
        if is_paused != self._is_paused:
            self._is_paused = is_paused
            self._pause.label = "Resume" if is_paused else "Pause"
            self._pause.icon = viser.Icon.PLAYER_PLAY if is_paused else viser.Icon.PLAYER_PAUSE

    def _tell(self, content: str) -> None:
        self._told.content, self._told.visible = content, True

    def _show_buttons(self) -> None:
        """Have Pause in the place of Execute while the robot moves, and Stop to be pressed."""
        is_moving = self._running is not None
        can_begin = self._offered is not None and self._offered != self.carried_out
        self._button.visible, self._pause.visible = not is_moving, is_moving
        self._button.disabled = is_moving or not can_begin
        self._stop.disabled = not is_moving
        self._speed.disabled = not (is_moving or can_begin)
        self._bar.visible = is_moving
