"""StageLog: progress of a task as events of its job."""

import time
from typing import Any

from planning.domain.report.motion_plan import Progress
from service.jobs.context import TaskContext

# Events are for people and progress bars: twenty a second are enough.
_EVENT_PERIOD = 0.05


class StageLog:
    """Tells the server which stage a plan is in; drops events that come too thick.

    With a stage come the seconds of those before it: they are known even if the process is ended.
    """

    def __init__(self, channel: TaskContext) -> None:
        """Speak through `channel`."""
        self._channel = channel
        self._stage = ""
        self._last = 0.0
        self._begun = 0.0
        self._timings: dict[str, float] = {}

    def __call__(self, progress: Progress) -> None:
        """Emit `stage` when it changes, else `progress` now and then."""
        if progress.best_length is not None:
            self._tell_best(progress)
            return
        now = time.monotonic()
        is_new = progress.stage != self._stage
        if not is_new and now - self._last < _EVENT_PERIOD:
            return
        told: dict[str, Any] = {
            "stage": progress.stage,
            "progress": progress.fraction,
            "detail": progress.detail,
        }
        if is_new:
            self._close(now)
            told["timings"] = dict(self._timings)
        self._stage, self._last = progress.stage, now
        self._channel.emit("stage" if is_new else "progress", told)

    def _close(self, now: float) -> None:
        """Count the time of the stage that ends."""
        if self._stage:
            spent = self._timings.get(self._stage, 0.0) + now - self._begun
            self._timings[self._stage] = round(spent, 6)
        self._begun = now

    def _tell_best(self, progress: Progress) -> None:
        told = {"detail": progress.detail, "length": progress.best_length}
        self._channel.emit("best-so-far", told)
