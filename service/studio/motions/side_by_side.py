"""SideBySide: motions of other plans, moved along with the one that is looked at."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.studio.cell import Cell
from service.studio.drawing.shapes import Paint
from service.studio.motions.keyframes import Keyframes, load_keyframes
from service.studio.newest import Newest
from service.studio.numbers import Array

_OPACITY = 0.4
# Of bodies that are where they were: a robot's base is drawn once [m or 1].
_STILL = 1e-6


@dataclass(frozen=True)
class Companion:
    """A plan that is shown beside others.

    Attributes:
        job: The plan, with its request and its result.
        color: Of its ghost: red, green, blue, 0 to 255.
    """

    job: Mapping[str, Any]
    color: tuple[int, int, int]

    @property
    def plan(self) -> str:
        """Its id."""
        return str(self.job["id"])


class SideBySide:
    """A ghost of each plan that was chosen to be shown beside the one that is looked at."""

    def __init__(
        self, cell: Cell, on_change: Callable[[], None], on_fault: Callable[[Exception], None]
    ) -> None:
        """Have none yet.

        Args:
            cell: The scene.
            on_change: Called once other plans are beside, from a thread.
            on_fault: Is told what goes wrong.
        """
        self._cell, self._on_change = cell, on_change
        self._newest = Newest(on_fault)
        self._lock = threading.RLock()
        self._companions: dict[str, Companion] = {}
        self._frames: dict[str, Keyframes] = {}
        self._shown: dict[str, float] = {}

    @property
    def jobs(self) -> list[Mapping[str, Any]]:
        """The plans that are beside, in the order in which they were asked for."""
        return [companion.job for companion in self._companions.values()]

    def choose(self, companions: Sequence[Companion]) -> None:
        """Have these plans beside, and no others."""
        self._newest.ask(lambda: self._take(companions))

    def duration(self, looked_at: str) -> float:
        """Return how long the longest motion takes that is beside a plan [s]."""
        return max((frames.duration for frames in self._others(looked_at)), default=0.0)

    def show(self, time: float, looked_at: str) -> None:
        """Put each ghost to a time [s]; what has ended stays at its own end.

        Args:
            time: From the start of all of them.
            looked_at: The plan that has a ghost already.
        """
        if not self._frames and not self._shown:
            return  # of one motion alone nothing is told
        with self._lock, self._cell.client.atomic():
            others = self._others(looked_at)
            self._hide({*self._shown} - {frames.plan for frames in others})
            for frames in others:
                own_time = min(time, frames.duration)
                if self._shown.get(frames.plan) != own_time:
                    paint = Paint(self._companions[frames.plan].color, _OPACITY, 0.0, False)  # noqa: FBT003
                    self._cell.view.show_beside(frames.plan, frames.at(own_time), paint)
                    self._shown[frames.plan] = own_time

    def hide(self) -> None:
        """Take the ghosts away, until they are shown again."""
        if not self._shown:
            return
        with self._lock, self._cell.client.atomic():
            self._hide({*self._shown})

    def close(self) -> None:
        """Have none any more."""
        self._newest.close()
        self.hide()

    def _others(self, looked_at: str) -> list[Keyframes]:
        with self._lock:
            return [frames for plan, frames in self._frames.items() if plan != looked_at]

    def _hide(self, plans: set[str]) -> None:
        for plan in plans:
            self._cell.view.show_beside(plan, None)
            del self._shown[plan]

    def _take(self, companions: Sequence[Companion]) -> None:
        loaded = {c.plan: self._frames.get(c.plan) or self._load(c.job) for c in companions}
        with self._lock:
            self._companions = {companion.plan: companion for companion in companions}
            self._frames = loaded
        self._on_change()

    def _load(self, job: Mapping[str, Any]) -> Keyframes:
        """Return a motion with the bodies that move in it."""
        cell, scene = self._cell, self._cell.scene
        group = scene.group(job["request"]["group"])
        frames = load_keyframes(cell.api, scene.id, group, job, cell.view.moving)
        moved = {name: poses for name, poses in frames.poses.items() if _is_moved(poses)}
        return Keyframes(frames.plan, frames.times, frames.positions, moved, frames.tool)


def _is_moved(poses: Array) -> bool:
    return bool(np.ptp(poses, axis=0).max() > _STILL)
