"""Stopwatch: seconds per stage, by a clock that is given."""

from collections.abc import Callable, Generator
from contextlib import contextmanager


class Stopwatch:
    """Adds up how long each stage took."""

    def __init__(self, clock: Callable[[], float]) -> None:
        """Start at zero, with a clock of monotonic seconds."""
        self._clock = clock
        self._began = clock()
        self._seconds: dict[str, float] = {}
        self._within = 0.0

    @contextmanager
    def stage(self, name: str) -> Generator[None]:
        """Count the time inside towards a stage; that of stages within it counts only for them."""
        began, before = self._clock(), self._within
        self._within = 0.0
        try:
            yield
        finally:
            elapsed = self._clock() - began
            self._seconds[name] = self._seconds.get(name, 0.0) + elapsed - self._within
            self._within = before + elapsed

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
