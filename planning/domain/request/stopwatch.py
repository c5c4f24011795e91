"""Stopwatch: seconds per pipeline stage by a given clock, and the stages that a deadline cut."""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager

from planning.errors import Canceled, DeadlineExceeded, StageFailure


def _ignore(_: str) -> None:
    pass


class Stopwatch:
    """Timer of the pipeline's stages [s], with the names of the stages cut short by a deadline."""

    def __init__(
        self, clock: Callable[[], float], on_stage: Callable[[str], None] = _ignore
    ) -> None:
        """Start at zero.

        Args:
            clock: Monotonic seconds.
            on_stage: Called with the name of every stage that begins, except stages within another.
        """
        self._clock = clock
        self._on_stage = on_stage
        self._start_time = clock()
        self._seconds: dict[str, float] = {}
        self._nested_seconds = 0.0
        self._running_stages: list[str] = []
        self._cut_stages: dict[str, None] = {}

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Count the time inside the block towards a stage; a nested stage's time counts only there.

        `DeadlineExceeded` and `Canceled` raised inside get the stage's name, that of the outermost
        stage if several are nested.
        """
        if not self._running_stages:
            self._on_stage(name)
        start_time, outer_nested_seconds = self._clock(), self._nested_seconds
        self._nested_seconds = 0.0
        self._running_stages.append(name)
        try:
            yield
        except (DeadlineExceeded, Canceled) as failure:
            failure.in_stage(name)
            raise
        finally:
            self._running_stages.pop()
            elapsed = self._clock() - start_time
            self._seconds[name] = self._seconds.get(name, 0.0) + elapsed - self._nested_seconds
            self._nested_seconds = outer_nested_seconds + elapsed

    def each[T](self, name: str, items: Iterable[T]) -> Generator[T]:
        """Yield the items of an iterable; the time to produce each counts towards a stage."""
        iterator = iter(items)
        while True:
            with self.stage(name):
                try:
                    item = next(iterator)
                except StopIteration:
                    return
            yield item

    @contextmanager
    def timing_failures(self) -> Generator[None]:
        """Attach the seconds so far to every failure of a stage that is raised inside the block."""
        try:
            yield
        except StageFailure as failure:
            failure.timings = self.seconds
            raise

    def record_cut(self) -> None:
        """Record that a deadline cut the innermost running stage short."""
        if self._running_stages:
            self._cut_stages[self._running_stages[-1]] = None

    @property
    def cut_short(self) -> tuple[str, ...]:
        """Names of the stages that a deadline cut short, in the order of their first cuts."""
        return tuple(self._cut_stages)

    @contextmanager
    def measure(self, name: str) -> Generator[None]:
        """Count the time inside the block towards a name, and towards its stage as well."""
        start_time = self._clock()
        try:
            yield
        finally:
            self._seconds[name] = self._seconds.get(name, 0.0) + self._clock() - start_time

    def add(self, name: str, seconds: float) -> None:
        """Add time that was measured elsewhere to a name; no stage's own time changes."""
        self._seconds[name] = self._seconds.get(name, 0.0) + seconds

    @property
    def seconds_by_name(self) -> dict[str, float]:
        """Seconds by name."""
        return dict(self._seconds)

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds by stage, and in `total` the seconds since the start."""
        return {**self._seconds, "total": self._clock() - self._start_time}
