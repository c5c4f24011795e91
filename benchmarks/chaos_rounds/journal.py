"""Journal: what clients asked a server for, what it answered, and what was seen of each job."""

import threading
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from benchmarks.chaos_rounds.mix import HANGS, SEGFAULTS

FINAL = {
    "plan": frozenset({"succeeded", "failed", "canceled"}),
    "execution": frozenset({"succeeded", "aborted", "canceled"}),
}

_POISONS: dict[Any, str] = {HANGS: "hanging", SEGFAULTS: "segfaulting"}


@dataclass(frozen=True)
class Violation:
    """Something that must hold and does not.

    Attributes:
        rule: Which.
        job: Id of the job, or of what else it is about.
        what: Was seen.
    """

    rule: str
    job: str
    what: str

    def __str__(self) -> str:
        return f"{self.rule}: {self.job}: {self.what}"


@dataclass(frozen=True)
class Glimpse:
    """How far an execution was when a client looked.

    Attributes:
        num_losses: How often anything had been lost before, that is, the server been killed.
        time: Along the motion [s].
    """

    num_losses: int
    time: float


@dataclass(frozen=True)
class Event:
    """An event of a job: its number, type and data."""

    number: int
    type: str
    data: dict[str, Any]


@dataclass
class Asked:
    """A job that a server accepted.

    Attributes:
        kind: "plan" or "execution".
        key: Idempotency key of the request.
        body: Of the request.
        id: Of the job.
        ends: Every final state that was seen, in order.
        cancels: What the answers to `/cancel` called unrecorded.
        glimpses: Of an execution.
        num_losses: When its end was seen: how often anything had been lost before.
        streamed: The events that were followed while it went on, in the order in which they came.
        stood: Positions in the scene right after the end of an execution, and those of its status.
    """

    kind: str
    key: str
    body: dict[str, Any]
    id: str
    ends: list[str] = field(default_factory=list)
    cancels: list[list[str]] = field(default_factory=list)
    glimpses: list[Glimpse] = field(default_factory=list)
    num_losses: int = 0
    streamed: list[Event] = field(default_factory=list)
    stood: tuple[list[float], list[float]] | None = None

    @property
    def poison(self) -> str:
        """What a plan does to the process that makes it; empty for nothing."""
        return _POISONS.get(self.body.get("seed"), "") if self.kind == "plan" else ""

    def see(self, job: dict[str, Any]) -> bool:
        """Note the state of an answer, and return whether it is final."""
        is_final = job["state"] in FINAL[self.kind]
        if is_final:
            self.ends.append(job["state"])
        return is_final


class Journal:
    """Written by many threads.

    Attributes:
        asked: Every job that was accepted.
        violations: That were seen while clients asked.
        answers: How many answers there were by status and code, those to repeat included.
    """

    def __init__(self) -> None:
        """Begin empty."""
        self.asked: list[Asked] = []
        self.violations: list[Violation] = []
        self.answers: Counter[str] = Counter()
        self._lock = threading.Lock()

    def accept(self, asked: Asked) -> Asked:
        """Note a job that was accepted."""
        with self._lock:
            self.asked.append(asked)
        return asked

    def count(self, answer: str) -> None:
        """Count an answer."""
        with self._lock:
            self.answers[answer] += 1

    def blame(self, rule: str, job: str, what: str) -> None:
        """Note a violation, the same one once."""
        with self._lock:
            if (found := Violation(rule, job, what)) not in self.violations:
                self.violations.append(found)
