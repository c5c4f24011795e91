"""Pool: slots that several lanes share, which of them are idle, and what each is warm with."""

from collections import OrderedDict
from collections.abc import Sequence

from service.jobs.worker.assignment import Worker

# Workers keep about as many scenes loaded.
_KEYS_PER_SLOT = 8


class WorkerPool:
    """Knows which slot is best for a key; has no clock and starts nothing."""

    def __init__(self, slots: Sequence[Worker]) -> None:
        """Start with no slot idle; `give_back` makes one so."""
        self.workers = list(slots)
        self._idle: list[Worker] = []
        self._keys: dict[int, OrderedDict[str, None]] = {}
        self._generations: dict[int, int] = {}

    @property
    def has_idle(self) -> bool:
        """Whether a slot is idle."""
        return bool(self._idle)

    def give_back(self, slot: Worker) -> None:
        """Let a slot be idle."""
        self._idle.append(slot)

    def take(self, key: str | None) -> Worker:
        """Take an idle slot: one that is warm for the key, else the one with the fewest keys."""
        warm = [slot for slot in self._idle if self.is_warm(slot, key)]
        slot = warm[0] if warm else min(self._idle, key=lambda idle: len(self._keys_of(idle)))
        self._idle.remove(slot)
        if key is not None:
            self.warm(slot, key)
        return slot

    def is_warm(self, slot: Worker, key: str | None) -> bool:
        """Return whether a slot is warm for a key."""
        return key is not None and key in self._keys_of(slot)

    def has_warm_idle(self, key: str | None) -> bool:
        """Return whether an idle slot is warm for a key."""
        return any(self.is_warm(slot, key) for slot in self._idle)

    def is_warm_elsewhere(self, key: str | None) -> bool:
        """Return whether a busy slot is warm for a key, and no idle one."""
        if self.has_warm_idle(key):
            return False
        return any(self.is_warm(slot, key) for slot in self.workers)

    def warm(self, slot: Worker, key: str) -> None:
        """Note that a slot is warm for a key from now on."""
        keys = self._keys_of(slot)
        keys[key] = None
        keys.move_to_end(key)
        if len(keys) > _KEYS_PER_SLOT:
            keys.popitem(last=False)

    def _keys_of(self, slot: Worker) -> OrderedDict[str, None]:
        """Return what a slot is warm with; nothing if its process is another by now."""
        if self._generations.get(id(slot)) != slot.generation:
            self._generations[id(slot)] = slot.generation
            self._keys[id(slot)] = OrderedDict()
        return self._keys[id(slot)]
