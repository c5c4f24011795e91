"""How long runs take: each kind of call by itself, and how many runs end in a second."""

import math
from collections import OrderedDict, deque
from dataclasses import dataclass

# What takes no longer may have the worker that is reserved for what is short [s].
SHORT = 0.5
# Number of worlds, and of kinds of calls about them, that are remembered.
_MAX_REMEMBERED = 4096
# Ends that are longer ago say nothing of the throughput [s].
_WINDOW = 60.0


@dataclass(frozen=True)
class CallKind:
    """What calls that take about as long have in common.

    Attributes:
        task: Their task.
        size: How much is requested, in powers of two.
        is_load: Whether a scene is loaded anew, even where one is loaded already.
    """

    task: str
    size: int = 0
    is_load: bool = False


class DurationHistory:
    """Remembers the last duration of calls by kind and world, and of loading a world."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._runs: OrderedDict[tuple[CallKind, str | None], float] = OrderedDict()
        self._loads: OrderedDict[str | None, float] = OrderedDict()

    def is_short(self, kind: CallKind, digest: str | None, *, is_warm: bool) -> bool:
        """Return whether a call is likely to be short.

        A world that was not loaded yet may take minutes; a call to a loaded one of a kind that it
        had not yet is likely to be short.

        Args:
            kind: Of the call.
            digest: Of its world, or None.
            is_warm: Whether the world is loaded where the call would run.
        """
        load = self._loads.get(digest, math.inf)
        known = self._runs.get((kind, digest))
        if kind.is_load:
            expected = load if known is None else known
        elif is_warm or digest is None:
            expected = known or 0.0
        else:
            expected = load + (known or 0.0)
        return expected <= SHORT

    def record_run(
        self, kind: CallKind, digest: str | None, seconds: float, *, was_warm: bool
    ) -> None:
        """Remember how long a call took, with the load of its world if that was not warm."""
        if kind.is_load or was_warm or digest is None:
            _put(self._runs, (kind, digest), seconds)
        else:
            _put(self._loads, digest, seconds)

    def record_load(self, digest: str, seconds: float) -> None:
        """Remember how long a world took to load."""
        _put(self._loads, digest, seconds)


class Throughput:
    """How many runs end in a second, measured over the last minute while something waits.

    What ended while nothing waited says how much was requested, not how much there is to give.
    """

    def __init__(self) -> None:
        """Begin with no end."""
        self._since = 0.0
        self._ends: deque[float] = deque()

    def restart(self, now: float) -> None:
        """Measure from now on: something begins to wait."""
        self._since = now
        self._ends.clear()

    def record_end(self, now: float) -> None:
        """Count a run that ends."""
        self._ends.append(now)
        self._forget(now)

    def per_second(self, now: float) -> float:
        """Return the ends per second [1/s], as if one had come in the second before the first."""
        self._forget(now)
        measured = min(_WINDOW, max(0.0, now - self._since))
        return (len(self._ends) + 1) / (measured + 1.0)

    def _forget(self, now: float) -> None:
        while self._ends and self._ends[0] <= now - _WINDOW:
            self._ends.popleft()


def _put[K](durations: OrderedDict[K, float], key: K, seconds: float) -> None:
    durations[key] = seconds
    durations.move_to_end(key)
    if len(durations) > _MAX_REMEMBERED:
        durations.popitem(last=False)
