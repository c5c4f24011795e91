"""RobotPanel: carry a plan out: start, pause, resume, stop, and change its speed."""

import threading
from collections.abc import Callable

import numpy as np
import viser

from service.studio import texts
from service.studio.cell import Cell

# Of the way back, of the fastest way there, and between them.
_BACK, _FASTEST, _STEP = -1.0, 3.0, 0.1
_FINAL = {"succeeded", "canceled", "aborted"}


class RobotPanel:
    """The buttons that move the robot, and where it is."""

    def __init__(
        self,
        gui: viser.GuiApi,
        on_execute: Callable[[], None],
        on_fault: Callable[[Exception], None],
    ) -> None:
        """Show the button.

        Args:
            gui: Where it is shown, in the container that is open.
            on_execute: Called when it is pressed.
            on_fault: Is told what goes wrong.
        """
        self._on_fault = on_fault
        self._button = gui.add_button(
            "Execute", icon=viser.Icon.ROBOT, color="orange", disabled=True
        )
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, visible=False)
        self._stop = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, color="red", visible=False)
        self._speed = gui.add_slider(
            "Speed",
            _BACK,
            _FASTEST,
            _STEP,
            1.0,
            visible=False,
            hint="0 rests on the path; below 0 the robot goes back along it",
        )
        self._bar = gui.add_progress_bar(0.0, color="orange", visible=False)
        self._told = gui.add_html(texts.told(""), visible=False)
        self._button.on_click(lambda _: on_execute())
        self._pause.on_click(lambda _: self._control("resume" if self._is_paused else "pause"))
        self._stop.on_click(lambda _: self._control("cancel"))
        self._speed.on_update(lambda event: self._set_speed() if event.client else None)
        self._is_paused = False
        self._running: tuple[Cell, str] | None = None
        self._lock = threading.Lock()

    def offer(self, *, can_execute: bool) -> None:
        """Let the button be pressed, or not, and show its speed."""
        self._button.disabled = not can_execute
        self._speed.visible = can_execute

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
            self._running = cell, execution.id
            self._show(is_moving=True)
            for event in cell.api.execution_events(execution.id):
                if event.type == "status":
                    self._follow(event.data)
                elif event.type == "controls" and event.data.get("is_paused") is not None:
                    self._show_pause(is_paused=bool(event.data["is_paused"]))
            ended = cell.api.execution(execution.id)
            if ended.status is not None:
                cell.show(np.array(ended.status.positions))
            return self._ended(ended.state, ended.failure and ended.failure.detail)
        finally:
            self._running = None
            self._show(is_moving=False)
            self._lock.release()

    def say_refused(self, detail: str) -> None:
        """Say why the server does not carry a motion out."""
        self._tell(texts.failure("not_certified", detail))
        self.offer(can_execute=True)

    def clear(self) -> None:
        """Say nothing, once the scene is another one."""
        self._told.visible = False
        self.offer(can_execute=False)

    def _ended(self, state: str, detail: str | None) -> bool:
        is_there = state == "succeeded"
        text = "arrived" if is_there else f"{state}: {detail or ''}"
        self._tell(texts.told(text, "good" if is_there else "bad"))
        return is_there

    def _follow(self, data: dict[str, object]) -> None:
        status = {**data}
        progress = float(str(status["progress"]))
        self._bar.value = 100.0 * progress
        self._show_pause(is_paused=status["state"] == "paused")
        if status["state"] not in _FINAL:
            off = 1000 * float(str(status.get("tracking_error") or 0.0))
            text = f"{status['state']} · {100 * progress:.0f} % · {off:.1f} mrad (or mm) off"
            self._tell(texts.told(text, "busy"))

    def _control(self, what: str, **body: float) -> None:
        running = self._running
        if running is None:
            return
        cell, execution = running
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

    def _show(self, *, is_moving: bool) -> None:
        self._button.disabled = True
        self._pause.visible = self._stop.visible = self._bar.visible = is_moving
        self._speed.visible = is_moving
        self._bar.value = 0.0
        self._show_pause(is_paused=False)
