"""Lane: what waits, and the slots that it waits for.

First come, first served within a priority. A ticket prefers an idle slot that is warm for its key.
If the slots that are warm for it are busy, it lets others go first, but only for a while: a load is
worth a short wait, never a long one.
"""

import bisect
import itertools
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from service.jobs.slot import Slot

# Workers keep about as many scenes loaded.
_KEYS_PER_SLOT = 8
_LONGEST_RETRY = 60


@dataclass(frozen=True)
class Ticket:
    """Something that waits for a slot.

    Attributes:
        name: Of the job, for taking it back.
        warm_key: What it is warm with, or None.
        priority: Larger comes first.
        since: When it began to wait [s].
        order: Its place among equals; assigned by the lane, and kept when it comes again.
        use: Called with its slot when it has one.
    """

    name: str
    warm_key: str | None
    priority: int
    since: float
    use: Callable[[Slot], None]
    order: int = field(default=-1)


@dataclass(frozen=True)
class Assignments:
    """What a lane decided.

    Attributes:
        pairs: Tickets and their slots.
        look_again: When to decide anew if nothing happens before [s], or None.
    """

    pairs: list[tuple[Ticket, Slot]]
    look_again: float | None


class Lane:
    """Decides who gets which slot; has no clock and starts nothing."""

    def __init__(
        self,
        name: str,
        slots: Sequence[Slot],
        max_waiting: int,
        cancel_grace: float = 0.25,
        warm_wait: float = 0.1,
    ) -> None:
        """Start with no slot idle; `give_back` makes one so.

        Args:
            name: For messages.
            slots: Where its jobs run.
            max_waiting: How many may wait.
            cancel_grace: How long a canceled job may take to end by itself [s].
            warm_wait: How long a ticket waits for a warm slot while others are idle [s].
        """
        self.name = name
        self.slots = list(slots)
        self.max_waiting = max_waiting
        self.cancel_grace = cancel_grace
        self._warm_wait = warm_wait
        self._idle: list[Slot] = []
        self._keys: dict[int, OrderedDict[str, None]] = {id(s): OrderedDict() for s in slots}
        self._waiting: list[Ticket] = []
        self._orders = itertools.count()
        self._mean_run = 1.0

    @property
    def num_waiting(self) -> int:
        """How many tickets wait."""
        return len(self._waiting)

    @property
    def is_full(self) -> bool:
        """Whether no more may wait."""
        return len(self._waiting) >= self.max_waiting

    @property
    def retry_after(self) -> int:
        """When a place is likely to be free [s], by how long runs took lately."""
        rounds = (len(self._waiting) + 1) / max(1, len(self.slots))
        return max(1, min(_LONGEST_RETRY, math.ceil(rounds * self._mean_run / 2)))

    def next_order(self) -> int:
        """Return the place of who comes now."""
        return next(self._orders)

    def add(self, ticket: Ticket) -> None:
        """Let a ticket wait; one with an earlier order goes before."""
        bisect.insort(self._waiting, ticket, key=lambda other: (-other.priority, other.order))

    def remove(self, name: str) -> None:
        """Let a ticket wait no longer, if it did."""
        self._waiting = [ticket for ticket in self._waiting if ticket.name != name]

    def give_back(self, slot: Slot, seconds: float | None = None) -> None:
        """Let a slot be idle, after a run that took so long."""
        self._idle.append(slot)
        if seconds is not None:
            self._mean_run += 0.2 * (seconds - self._mean_run)

    def assign(self, now: float) -> Assignments:
        """Take the tickets that get a slot now out of the queue, and their slots."""
        pairs: list[tuple[Ticket, Slot]] = []
        left: list[Ticket] = []
        look_again: float | None = None
        for i, ticket in enumerate(self._waiting):
            if not self._idle:
                left += self._waiting[i:]
                break
            patience = ticket.since + self._warm_wait
            if now < patience and self._is_warm_elsewhere(ticket.warm_key):
                left.append(ticket)
                look_again = patience if look_again is None else min(look_again, patience)
            else:
                pairs.append((ticket, self._take(ticket.warm_key)))
        self._waiting = left
        return Assignments(pairs, look_again)

    def _is_warm(self, slot: Slot, key: str | None) -> bool:
        return key is not None and key in self._keys[id(slot)]

    def _is_warm_elsewhere(self, key: str | None) -> bool:
        """Whether a busy slot is warm for a key, and no idle one."""
        if any(self._is_warm(slot, key) for slot in self._idle):
            return False
        return any(self._is_warm(slot, key) for slot in self.slots)

    def _take(self, key: str | None) -> Slot:
        """Take an idle slot: one that is warm for the key, else the one with the fewest keys."""
        warm = [slot for slot in self._idle if self._is_warm(slot, key)]
        slot = warm[0] if warm else min(self._idle, key=lambda idle: len(self._keys[id(idle)]))
        self._idle.remove(slot)
        if key is not None:
            keys = self._keys[id(slot)]
            keys[key] = None
            keys.move_to_end(key)
            if len(keys) > _KEYS_PER_SLOT:
                keys.popitem(last=False)
        return slot

    def cool(self, slot: Slot) -> None:
        """Forget what a slot was warm with: its process is another."""
        self._keys[id(slot)].clear()
