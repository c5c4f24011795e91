"""Measure: numbers of one kind, and how often there was none."""

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich.table import Table


@dataclass
class Measure:
    """What was measured of one thing.

    Attributes:
        what: It is.
        seconds: Of each time that it was done [s].
        rate: How often it is done a second, if that is what counts [1/s].
        faults: Why there is no number, once for each time that there is none.
        limit: What takes longer is a fault [s].
        mebibytes: Of memory, if that is what counts [MiB].
    """

    what: str
    seconds: list[float] = field(default_factory=list)
    rate: float | None = None
    faults: list[str] = field(default_factory=list)
    limit: float | None = None
    mebibytes: float | None = None

    @property
    def num_done(self) -> int:
        """How often it was done."""
        return len(self.seconds)

    def plain(self) -> dict[str, Any]:
        """Return the numbers, JSON-compatible."""
        known = {"what": self.what, "done": self.num_done, "faults": self.faults}
        milliseconds = {name: _or_none(self._at(share)) for name, share in _SHARES.items()}
        counts = {"rate": self.rate, "limit": self.limit, "mebibytes": self.mebibytes}
        return {**known, **counts, "ms": milliseconds}

    def cells(self) -> list[str]:
        """Return the row of a table."""
        at = [_shown(self._at(share)) for share in _SHARES.values()]
        rate = "" if self.rate is None else f"{self.rate:.0f}"
        faults = sorted({fault[:90] for fault in self.faults})
        told = f"{len(self.faults)}: {'; '.join(faults)}" if faults else "0"
        memory = "" if self.mebibytes is None else f"{self.mebibytes:.0f}"
        return [self.what, str(self.num_done), *at, rate, memory, told]

    def _at(self, share: float) -> float:
        """Return the milliseconds that a share of all are done within."""
        return 1e3 * quantile(self.seconds, share)


_SHARES = {"median": 0.5, "p95": 0.95, "p99": 0.99, "worst": 1.0}


def quantile(numbers: Sequence[float], share: float) -> float:
    """Return what a share of the numbers are below, linearly between ranks; nan of none."""
    if len(numbers) < 2:
        return numbers[0] if numbers else math.nan
    if share == 0.5:
        return statistics.median(numbers)
    ranked = sorted(numbers)
    place = share * (len(ranked) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ranked) - 1)
    return ranked[below] + (place - below) * (ranked[above] - ranked[below])


def table(measures: Iterable[Measure]) -> Table:
    """Return all measures, a row each."""
    made = Table(title="the service over HTTP; milliseconds")
    made.add_column("what")
    for head in ("done", *_SHARES, "a second", "MiB", "failed"):
        made.add_column(head, justify="left" if head == "failed" else "right")
    for measure in measures:
        made.add_row(*measure.cells())
    return made


def _shown(number: float) -> str:
    if math.isnan(number):
        return "-"
    return f"{number:.1f}" if number < 100 else f"{number:.0f}"


def _or_none(number: float) -> float | None:
    return None if math.isnan(number) else number
