"""What a task says of its stages, and how long those before took."""

import pytest

from planning.domain.report.motion_plan import Progress
from service.jobs.worker.progress import ProgressReporter
from tests.clocks import FakeClock


class TaskContext:
    """Keeps what is emitted."""

    def __init__(self):
        self.events = []

    def emit(self, event_type, data):
        self.events.append((event_type, data))


def test_a_stage_comes_with_the_seconds_of_those_before(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, channel = FakeClock(now=100.0), TaskContext()
    monkeypatch.setattr("time.monotonic", clock)
    log = ProgressReporter(channel)
    for stage, lasts in (("load", 0.5), ("search", 2.0), ("certify", 1.0), ("search", 0.25)):
        log(Progress(stage, 0.1))
        clock.advance(lasts / 2)
        log(Progress(stage, 0.2, "half way"))
        log(Progress(stage, 0.2, "too soon to tell"))
        clock.advance(lasts / 2)
    log(Progress("certify", 0.9))
    told = [(data["stage"], data["timings"]) for kind, data in channel.events if kind == "stage"]
    assert told == [
        ("load", {}),
        ("search", {"load": 0.5}),
        ("certify", {"load": 0.5, "search": 2.0}),
        ("search", {"load": 0.5, "search": 2.0, "certify": 1.0}),
        ("certify", {"load": 0.5, "search": 2.25, "certify": 1.0}),
    ]
    assert [kind for kind, _ in channel.events].count("progress") == 4
