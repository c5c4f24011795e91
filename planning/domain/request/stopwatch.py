"""Stopwatch: seconds per pipeline stage by a given clock, and the stages that a deadline cut."""

from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager

from planning.errors import Canceled, DeadlineExceeded, PlanningFailure


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
        self._began = clock()
        self._seconds: dict[str, float] = {}
        self._within = 0.0
        self._open: list[str] = []
        self._cut: dict[str, None] = {}

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Count the time inside the block towards a stage; a nested stage's time counts only there.

        `DeadlineExceeded` and `Canceled` raised inside get the stage's name, that of the outermost
        stage if several are nested.
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
        """Yield the items of an iterable; the time to produce each counts towards a stage."""
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
        """Attach the seconds so far to every planning failure that is raised inside the block."""
        try:
            yield
        except PlanningFailure as failure:
            failure.timings = self.seconds
            raise

    def note_cut(self) -> None:
        """Record that a deadline cut the innermost running stage short."""
        if self._open:
            self._cut[self._open[-1]] = None

    @property
    def cut_short(self) -> tuple[str, ...]:
        """Names of the stages that a deadline cut short, in the order of their first cuts."""
        return tuple(self._cut)

    @contextmanager
    def note(self, name: str) -> Generator[None]:
        """Count the time inside the block towards a name, and towards its stage as well."""
        began = self._clock()
        try:
            yield
        finally:
            self._seconds[name] = self._seconds.get(name, 0.0) + self._clock() - began

    def add(self, name: str, seconds: float) -> None:
        """Add time that was measured elsewhere to a name; no stage's own time changes."""
        self._seconds[name] = self._seconds.get(name, 0.0) + seconds

    @property
    def parts(self) -> dict[str, float]:
        """Seconds by name."""
        return dict(self._seconds)

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds by stage, and in `total` the seconds since the start."""
        return {**self._seconds, "total": self._clock() - self._began}
