"""Rows of the benchmark's tables: numbers by the heads of their columns, and faults."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from rich.table import Table

from benchmarks.service_load.measure import quantile


@dataclass
class Row:
    """What was measured of one thing.

    Attributes:
        what: It is.
        numbers: By the heads of their columns; what is not there was not measured.
        faults: What went wrong.
    """

    what: str
    numbers: dict[str, float] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    def note_jitter(self, jitter: dict[str, Any]) -> None:
        """Note how late the ticks of a controller were, in milliseconds."""
        for name in ("median", "p99", "max"):
            self.numbers[f"jitter {name} ms"] = 1e3 * jitter[name]

    def note_times(self, seconds: Sequence[float]) -> None:
        """Note how long answers took, in milliseconds."""
        if not seconds:
            self.faults.append("nothing was measured")
            return
        for name, share in {"median": 0.5, "p95": 0.95, "worst": 1.0}.items():
            self.numbers[f"{name} ms"] = 1e3 * quantile(seconds, share)

    def plain(self) -> dict[str, Any]:
        """Return it, JSON-compatible."""
        return {"what": self.what, "numbers": self.numbers, "faults": self.faults}


def table_of(title: str, rows: Sequence[Row]) -> Table:
    """Return rows of one section, with the columns that any of them has."""
    heads = list(dict.fromkeys(head for row in rows for head in row.numbers))
    made = Table(title=title)
    made.add_column("what")
    for head in heads:
        made.add_column(head, justify="right")
    made.add_column("failed")
    for row in rows:
        cells = [_shown(row.numbers.get(head, math.nan)) for head in heads]
        made.add_row(row.what, *cells, "; ".join(row.faults) or "0")
    return made


def _shown(number: float) -> str:
    return "-" if math.isnan(number) else f"{number:.2f}" if number < 10 else f"{number:.0f}"
