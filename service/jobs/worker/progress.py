"""ProgressReporter: progress of a task as events of its job."""

import time
from typing import Any

from planning.domain.report.motion_plan import Progress
from service.jobs.context import TaskContext

# Events are for people and progress bars: twenty a second are enough.
_EVENT_PERIOD = 0.05


class ProgressReporter:
    """Reports to the server which stage a plan is in, at most twenty times a second.

    With a stage come the seconds of those before it: they are known even if the process is ended.
    """

    def __init__(self, context: TaskContext) -> None:
        """Report to the server through `context`."""
        self._context = context
        self._stage = ""
        self._last = 0.0
        self._begun = 0.0
        self._timings: dict[str, float] = {}

    def __call__(self, progress: Progress) -> None:
        """Emit `stage` when it changes, else `progress` now and then."""
        if progress.best_length is not None:
            self._report_best(progress)
            return
        now = time.monotonic()
        is_new = progress.stage != self._stage
        if not is_new and now - self._last < _EVENT_PERIOD:
            return
        data: dict[str, Any] = {
            "stage": progress.stage,
            "progress": progress.fraction,
            "detail": progress.detail,
        }
        if is_new:
            self._close(now)
            data["timings"] = dict(self._timings)
        self._stage, self._last = progress.stage, now
        self._context.emit("stage" if is_new else "progress", data)

    def _close(self, now: float) -> None:
        """Count the time of the stage that ends."""
        if self._stage:
            spent = self._timings.get(self._stage, 0.0) + now - self._begun
            self._timings[self._stage] = round(spent, 6)
        self._begun = now

    def _report_best(self, progress: Progress) -> None:
        data = {"detail": progress.detail, "length": progress.best_length}
        self._context.emit("best-so-far", data)
