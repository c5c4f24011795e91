"""Fleet: the servers of one database; one that ends by itself is started again."""

import itertools
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress

import httpx

from benchmarks.chaos_rounds.keeper import Keeper
from benchmarks.serving.processes import Process
from benchmarks.serving.server import NotStarted

# Between two looks at whether all servers run [s].
_LOOK = 0.5
_ANSWER_WITHIN = 2.0


class Fleet:
    """One server or several that share a database; a client talks to any of them that is there.

    Attributes:
        keepers: One for each server.
    """

    def __init__(self, keepers: Sequence[Keeper]) -> None:
        """Have some servers; call `start`."""
        self.keepers = tuple(keepers)
        self._turns = itertools.count()

    @property
    def url(self) -> str:
        """Where the server listens that is asked next; empty while there is none."""
        there = [url for keeper in self.keepers if (url := keeper.url)]
        return there[next(self._turns) % len(there)] if there else ""

    @property
    def losses(self) -> int:
        """How often a server was killed, in all."""
        return sum(keeper.losses for keeper in self.keepers)

    @property
    def starts(self) -> int:
        """How often a server came to listen, in all."""
        return sum(keeper.starts for keeper in self.keepers)

    @property
    def refused(self) -> int:
        """How often a server could not start, because of a fault that was there on purpose."""
        return sum(keeper.refused for keeper in self.keepers)

    @property
    def stood_down(self) -> int:
        """How often a server ended because another one had taken the database over."""
        return sum(keeper.stood_down for keeper in self.keepers)

    def workers(self) -> list[Process]:
        """Return the processes that run tasks of any server."""
        return list(dict.fromkeys(one for keeper in self.keepers for one in keeper.workers()))

    def hosts(self) -> list[Process]:
        """Return the processes that own workers elsewhere, of any server."""
        return list(dict.fromkeys(one for keeper in self.keepers for one in keeper.hosts()))

    def by_role(self, role: str) -> list[Keeper]:
        """Return the servers that say just now that they are leaders, or followers."""
        return [keeper for keeper in self.keepers if _role(keeper.url) == role]

    def start(self) -> None:
        """Start all servers, one after the other; raises as `Keeper.start`."""
        for keeper in self.keepers:
            keeper.start()

    def end(self) -> None:
        """Have those servers end that there are, and blame what they leave running."""
        for keeper in self.keepers:
            if keeper.url:
                keeper.end()
        for keeper in self.keepers:
            keeper.check_gone()

    @contextmanager
    def watched(self, is_troubled: Callable[[], bool]) -> Iterator[None]:
        """Have servers that end by themselves started again.

        Args:
            is_troubled: Whether a fault is there now that may keep one from its start.
        """
        done = threading.Event()

        def watch() -> None:
            while not done.wait(_LOOK):
                for keeper in self.keepers:
                    with suppress(NotStarted):  # it is in the journal
                        keeper.revive(is_troubled)

        thread = threading.Thread(target=watch)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()


def _role(url: str) -> str:
    """Return the role of the server at an address; empty if it does not tell."""
    try:
        answer = httpx.get(f"{url}/readyz", timeout=_ANSWER_WITHIN, trust_env=False)
        return str(answer.json()["role"]) if answer.is_success else ""
    except (httpx.TransportError, httpx.UnsupportedProtocol):
        return ""
