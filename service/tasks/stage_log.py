"""StageLog: progress of a task as events of its job."""

import time

from planning.domain.plan import Progress
from service.tasks.channel import Channel

# Events are for people and progress bars: twenty a second are enough.
_EVENT_PERIOD = 0.05


class StageLog:
    """Tells the server which stage a plan is in; drops events that come too thick."""

    def __init__(self, channel: Channel) -> None:
        """Speak through `channel`."""
        self._channel = channel
        self._stage = ""
        self._last = 0.0

    def __call__(self, progress: Progress) -> None:
        """Emit `stage` when it changes, else `progress` now and then."""
        if progress.best_length is not None:
            self._tell_best(progress)
            return
        now = time.monotonic()
        is_new = progress.stage != self._stage
        if not is_new and now - self._last < _EVENT_PERIOD:
            return
        self._stage, self._last = progress.stage, now
        told = {"stage": progress.stage, "progress": progress.fraction, "detail": progress.detail}
        self._channel.emit("stage" if is_new else "progress", told)

    def _tell_best(self, progress: Progress) -> None:
        told = {"detail": progress.detail, "length": progress.best_length}
        self._channel.emit("best-so-far", told)
