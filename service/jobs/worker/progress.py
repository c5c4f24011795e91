"""ProgressReporter: progress of a task as events of its job."""

import math
import time
from typing import Any

import numpy as np

from planning.domain.report.best_path import BestPath
from planning.domain.report.motion_plan import Progress
from service.jobs.context import TaskContext

# Events are for people and progress bars: twenty a second are enough.
_EVENT_PERIOD = 0.05
# While a stage says nothing of itself, its share of the allowed time is told this often [s].
_TIME_PERIOD = 0.5
# A stage that uses all its time is not yet in the next one.
_LARGEST_SHARE = 0.99
# Of the best path so far, in each event that tells it: enough to draw it, and a few kilobytes.
MAX_BEST_WAYPOINTS = 64
_DECIMALS = 6


class ProgressReporter:
    """Reports to the server which stage a plan is in, at most twenty times a second.

    With a stage come the seconds of those before it: they are known even if the process is ended.
    Within a stage whose end is known progress grows with the share of the remaining time that it
    has used. It never decreases.
    """

    def __init__(self, context: TaskContext) -> None:
        """Report to the server through `context`."""
        self._context = context
        self._last = self._begun = 0.0
        self._timings: dict[str, float] = {}
        self._start = time.monotonic()
        self._expires_at = math.inf
        self._latest = Progress("", 0.0)
        self._said_at, self._fraction = self._start, 0.0

    def set_deadline(self, expires_at: float) -> None:
        """Measure progress within stages by the time that is left until an instant [s]."""
        self._expires_at = expires_at

    def is_canceled(self) -> bool:
        """Return whether the end of the job was requested; asked often, it tells progress too."""
        if time.monotonic() - self._last >= _TIME_PERIOD:
            self.tell_time()
        return self._context.is_canceled()

    def __call__(self, progress: Progress) -> None:
        """Emit `stage` when it changes, else `progress` now and then."""
        if progress.best is not None:
            self._report_best(progress.best, progress.detail)
            return
        now = time.monotonic()
        is_new = progress.stage != self._latest.stage
        if not is_new and now - self._last < _EVENT_PERIOD:
            return
        timings: dict[str, Any] = {}
        if is_new:
            self._close(now)
            timings["timings"] = dict(self._timings)
        self._fraction = max(self._fraction, progress.fraction)
        self._latest, self._said_at = progress, now
        self._emit("stage" if is_new else "progress", now, timings)

    def tell_time(self) -> None:
        """Emit `progress` if the time that has passed makes a difference."""
        now, latest = time.monotonic(), self._latest
        if latest.until is None or math.isinf(self._expires_at):
            return
        share = min(1.0, (now - self._said_at) / max(1e-9, self._expires_at - self._said_at))
        reached = latest.fraction + (latest.until - latest.fraction) * _LARGEST_SHARE * share
        if reached > self._fraction:
            self._fraction = reached
            self._emit("progress", now, {})

    def _emit(self, event_type: str, now: float, more: dict[str, Any]) -> None:
        stage, detail = self._latest.stage, self._latest.detail
        self._last = now
        data = {"stage": stage, "progress": self._fraction, "detail": detail}
        self._context.emit(event_type, {**data, **more})

    def _close(self, now: float) -> None:
        """Count the time of the stage that ends."""
        stage = self._latest.stage
        if stage:
            spent = self._timings.get(stage, 0.0) + now - self._begun
            self._timings[stage] = round(spent, 6)
        self._begun = now

    def _report_best(self, best: BestPath, detail: str) -> None:
        seconds = round(time.monotonic() - self._start, 6)
        data: dict[str, Any] = {"detail": detail, "length": best.attempt.length, "seconds": seconds}
        if len(best.waypoints):
            data["waypoints"] = _thinned(best.waypoints)
        self._context.emit("best-so-far", data)


def _thinned(waypoints: np.ndarray[Any, np.dtype[np.float64]]) -> list[list[float]]:
    """Return a path to look at: at most some of its waypoints, the ends among them."""
    count = min(len(waypoints), MAX_BEST_WAYPOINTS)
    rows = np.linspace(0, len(waypoints) - 1, count).round().astype(int)
    return waypoints[rows].round(_DECIMALS).tolist()
