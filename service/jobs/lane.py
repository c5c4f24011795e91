"""Lane: jobs that wait, and the slots that they wait for."""

import heapq
from collections.abc import Sequence

from service.jobs.records import Job
from service.jobs.slot import Slot


class Lane:
    """First come, first served within a priority; a slot that is warm for the job is preferred."""

    def __init__(
        self, name: str, slots: Sequence[Slot], max_waiting: int, cancel_grace: float = 0.25
    ) -> None:
        """Start with every slot idle.

        Args:
            name: For messages.
            slots: Where its jobs run.
            max_waiting: How many jobs may wait.
            cancel_grace: How long a canceled job may take to end by itself [s].
        """
        self.name = name
        self.slots = list(slots)
        self.max_waiting = max_waiting
        self.cancel_grace = cancel_grace
        self._idle = list(slots)
        self._waiting: list[tuple[int, int, Job]] = []

    @property
    def num_waiting(self) -> int:
        """How many jobs wait."""
        return len(self._waiting)

    @property
    def is_full(self) -> bool:
        """Whether no more may wait."""
        return len(self._waiting) >= self.max_waiting

    def add(self, job: Job) -> None:
        """Let a job wait."""
        heapq.heappush(self._waiting, (-job.priority, job.serial, job))

    def remove(self, identifier: str) -> None:
        """Let a job wait no longer, if it did."""
        self._waiting = [entry for entry in self._waiting if entry[2].id != identifier]
        heapq.heapify(self._waiting)

    def take(self) -> tuple[Job, Slot] | None:
        """Return the next job and an idle slot for it, if there are both."""
        if not self._waiting or not self._idle:
            return None
        job = heapq.heappop(self._waiting)[2]
        return job, self.take_slot(job.warm_key)

    def take_slot(self, warm_key: str | None) -> Slot:
        """Return an idle slot: one that is warm for the key, else the one idle for longest."""
        warm = [slot for slot in self._idle if warm_key is not None and slot.warm_key == warm_key]
        slot = (warm or self._idle)[0]
        self._idle.remove(slot)
        slot.warm_key = warm_key
        return slot

    @property
    def has_idle_slot(self) -> bool:
        """Whether a slot has nothing to do."""
        return bool(self._idle)

    def give_back(self, slot: Slot) -> None:
        """Let a slot be idle again."""
        self._idle.append(slot)
