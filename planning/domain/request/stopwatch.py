"""Stopwatch: seconds per stage, by a clock that is given, and which stage is at work."""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager

from planning.errors import Canceled, DeadlineExceeded, PlanningFailure


def _ignore(_: str) -> None:
    pass


class Stopwatch:
    """Adds up how long each stage took, and knows which one was cut short."""

    def __init__(
        self, clock: Callable[[], float], on_stage: Callable[[str], None] = _ignore
    ) -> None:
        """Start at zero.

        Args:
            clock: Monotonic seconds.
            on_stage: Told the name of every stage that begins, but for those within another.
        """
        self._clock = clock
        self._on_stage = on_stage
        self._began = clock()
        self._seconds: dict[str, float] = {}
        self._within = 0.0
        self._open: list[str] = []
        self._cut: dict[str, None] = {}

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Count the time inside towards a stage; that of stages within it counts only for them.

        What ends by its deadline or a cancel inside is told that it was in this stage, the
        outermost one if there are several.
        """
        if not self._open:
            self._on_stage(name)
        began, before = self._clock(), self._within
        self._within = 0.0
        self._open.append(name)
        try:
            yield
        except (DeadlineExceeded, Canceled) as failure:
            failure.in_stage(name)
            raise
        finally:
            self._open.pop()
            elapsed = self._clock() - began
            self._seconds[name] = self._seconds.get(name, 0.0) + elapsed - self._within
            self._within = before + elapsed

    def each[T](self, name: str, found: Iterable[T]) -> Generator[T]:
        """Yield what is found; the time that finding it takes counts towards a stage."""
        rest = iter(found)
        while True:
            with self.stage(name):
                try:
                    one = next(rest)
                except StopIteration:
                    return
            yield one

    @contextmanager
    def timing_failures(self) -> Generator[None]:
        """Have failures that come from inside keep the seconds so far."""
        try:
            yield
        except PlanningFailure as failure:
            failure.timings = self.seconds
            raise

    def note_cut(self) -> None:
        """Note that a deadline cut the stage that is at work."""
        if self._open:
            self._cut[self._open[-1]] = None

    @property
    def cut_short(self) -> tuple[str, ...]:
        """The stages that a deadline cut, in the order of their first cuts."""
        return tuple(self._cut)

    @contextmanager
    def note(self, name: str) -> Generator[None]:
        """Count the time inside towards a name, and towards its stage all the same."""
        began = self._clock()
        try:
            yield
        finally:
            self._seconds[name] = self._seconds.get(name, 0.0) + self._clock() - began

    def add(self, name: str, seconds: float) -> None:
        """Count time that was spent elsewhere, and towards no stage."""
        self._seconds[name] = self._seconds.get(name, 0.0) + seconds

    @property
    def parts(self) -> dict[str, float]:
        """Seconds by name."""
        return dict(self._seconds)

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds by stage, and in `total` those since the start."""
        return {**self._seconds, "total": self._clock() - self._began}
