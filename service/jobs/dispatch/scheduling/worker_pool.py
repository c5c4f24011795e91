"""WorkerPool: workers of one or more queues, which are idle, and what each is warm with."""

from collections import OrderedDict
from collections.abc import Sequence

from service.jobs.worker.assignment import Worker

# Workers keep about as many scenes loaded.
_WORLDS_PER_WORKER = 8


class WorkerPool:
    """Knows which worker is best for a world; has no clock and starts nothing."""

    def __init__(self, workers: Sequence[Worker]) -> None:
        """Start with no worker idle; `give_back` makes one so."""
        self.workers = list(workers)
        self._idle: list[Worker] = []
        self._digests: dict[int, OrderedDict[str, None]] = {}
        self._generations: dict[int, int] = {}

    @property
    def has_idle(self) -> bool:
        """Whether a worker is idle."""
        return bool(self._idle)

    def give_back(self, worker: Worker) -> None:
        """Let a worker be idle."""
        self._idle.append(worker)

    def take_lost(self) -> list[Worker]:
        """Take the idle workers whose machines are lost."""
        lost = [worker for worker in self._idle if worker.is_lost]
        self._idle = [worker for worker in self._idle if not worker.is_lost]
        return lost

    def take(self, digest: str | None) -> Worker:
        """Take an idle worker: one that is warm for a world, else the one with the fewest."""
        warm = [worker for worker in self._idle if self.is_warm(worker, digest)]
        worker = warm[0] if warm else min(self._idle, key=lambda idle: len(self._digests_of(idle)))
        self._idle.remove(worker)
        if digest is not None:
            self.warm(worker, digest)
        return worker

    def is_warm(self, worker: Worker, digest: str | None) -> bool:
        """Return whether a worker is warm for a world."""
        return digest is not None and digest in self._digests_of(worker)

    def has_warm_idle(self, digest: str | None) -> bool:
        """Return whether an idle worker is warm for a world."""
        return any(self.is_warm(worker, digest) for worker in self._idle)

    def is_warm_elsewhere(self, digest: str | None) -> bool:
        """Return whether a busy worker is warm for a world, and no idle one."""
        if self.has_warm_idle(digest):
            return False
        return any(self.is_warm(worker, digest) for worker in self.workers)

    def warm(self, worker: Worker, digest: str) -> None:
        """Note that a worker is warm for a world from now on."""
        digests = self._digests_of(worker)
        digests[digest] = None
        digests.move_to_end(digest)
        if len(digests) > _WORLDS_PER_WORKER:
            digests.popitem(last=False)

    def _digests_of(self, worker: Worker) -> OrderedDict[str, None]:
        """Return what a worker is warm with; nothing if its process is another by now."""
        if self._generations.get(id(worker)) != worker.generation:
            self._generations[id(worker)] = worker.generation
            self._digests[id(worker)] = OrderedDict()
        return self._digests[id(worker)]
