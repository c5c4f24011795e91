"""Stopwatch: seconds per pipeline stage by a given clock, and the stages that a deadline cut."""

from collections.abc import Callable, Generator, Iterable
from contextlib import AbstractContextManager, contextmanager

from planning.errors import Canceled, DeadlineExceeded, StageFailure


def _ignore(_: str) -> None:
    pass


class _Stage:
    """Context of one stage: a plan has a dozen, and a generator for each takes twice as long."""

    __slots__ = ("_begun", "_name", "_watch")

    def __init__(self, watch: "Stopwatch", name: str) -> None:
        self._watch, self._name, self._begun = watch, name, (0.0, 0.0)

    def __enter__(self) -> None:
        self._begun = self._watch.begin_stage(self._name)

    def __exit__(self, kind: object, failure: object, trace: object) -> None:
        if isinstance(failure, (DeadlineExceeded, Canceled)):
            failure.in_stage(self._name)
        self._watch.end_stage(self._name, self._begun)


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

    def stage(self, name: str) -> AbstractContextManager[None]:
        """Count the time inside the block towards a stage; a nested stage's time counts only there.

        `DeadlineExceeded` and `Canceled` raised inside get the stage's name, that of the outermost
        stage if several are nested.
        """
        return _Stage(self, name)

    def begin_stage(self, name: str) -> tuple[float, float]:
        """Begin what `stage` times; return what `end_stage` needs."""
        if not self._running_stages:
            self._on_stage(name)
        begun = self._clock(), self._nested_seconds
        self._nested_seconds = 0.0
        self._running_stages.append(name)
        return begun

    def end_stage(self, name: str, begun: tuple[float, float]) -> None:
        """End it."""
        self._running_stages.pop()
        elapsed = self._clock() - begun[0]
        self._seconds[name] = self._seconds.get(name, 0.0) + elapsed - self._nested_seconds
        self._nested_seconds = begun[1] + elapsed

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
