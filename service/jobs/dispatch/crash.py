"""Crashes: a worker that died under a run is told in the log and counted, whatever follows.

A job that may run again succeeds most often, and shows nothing of it then.
"""

import logging
from dataclasses import dataclass

from service.jobs.dispatch.observer import Observer
from service.jobs.outcome import Crashed, MemoryExceeded, Outcome, Silent, error_of, signal_name

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Run:
    """One run of a task.

    Attributes:
        queue: Of its job or call.
        task: Its name.
        attempt: How often it was started, this time included.
        stage: The last one that it told of, or empty.
    """

    queue: str
    task: str
    attempt: int
    stage: str = ""


def note_crash(outcome: Outcome, run: Run, observer: Observer) -> None:
    """Tell of a run if its worker died under it; the ids that are bound say which job it was."""
    if not isinstance(outcome, Crashed | Silent | MemoryExceeded):
        return
    reason = _reason_of(outcome)
    facts = {"task": run.task, "stage": run.stage, "signal": reason, "attempt": run.attempt}
    _log.warning("a worker died: %s", error_of(outcome, run.attempt).detail, extra=facts)
    observer.note_crash(run.queue, reason)


def _reason_of(end: Crashed | Silent | MemoryExceeded) -> str:
    """Return what ended a worker, one of few: the name of a signal, `exit`, `silence`, `memory`."""
    match end:
        case Crashed(exit_code=code):
            return "exit" if code is None or code >= 0 else signal_name(-code)
        case Silent():
            return "silence"
        case MemoryExceeded():
            return "memory"
