"""What a task says of its stages, and how long those before took."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planning.domain.report.best_path import BestPath
from planning.domain.report.motion_plan import Progress
from planning.domain.report.search_report import AttemptReport
from planning.pipeline.context import StageProgress
from service.jobs.worker.progress import MAX_BEST_WAYPOINTS, ProgressReporter
from tests.clocks import FakeClock
from tests.profiles import rng_of


class TaskContext:
    """Keeps what is emitted."""

    def __init__(self):
        self.events = []

    def is_canceled(self):
        return False

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


def told(context):
    return [data["progress"] for kind, data in context.events if kind in {"stage", "progress"}]


def test_progress_grows_with_the_time_that_a_stage_uses(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, context = FakeClock(now=100.0), TaskContext()
    monkeypatch.setattr("time.monotonic", clock)
    log = ProgressReporter(context)
    log.set_deadline(110.0)
    log(Progress("search", 0.15, until=0.5))
    seen = []
    for _ in range(2000):
        assert not log.is_canceled()
        seen.append(told(context)[-1])
        clock.advance(0.01)
    assert seen == sorted(seen)
    assert seen[500] == pytest.approx(0.15 + 0.35 * 0.99 * 0.5, abs=0.02)
    assert seen[999] < seen[-1] < 0.5
    assert seen[-1] == pytest.approx(0.5, abs=0.01)
    # Twice a second, and no more once the time is over.
    assert len(context.events) <= 22
    log(Progress("refine", 0.5, until=0.6))
    assert told(context)[-1] == 0.5


@given(
    st.lists(
        st.tuples(st.sampled_from(["search", "refine", "certify"]), st.floats(0, 3)), max_size=30
    )
)
def test_progress_never_decreases(stages: list[tuple[str, float]]) -> None:
    clock, context = FakeClock(now=0.0), TaskContext()
    begins = {"search": 0.15, "refine": 0.5, "certify": 0.8}
    ends = {"search": 0.5, "refine": 0.8, "certify": 0.95}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("time.monotonic", clock)
        log = ProgressReporter(context)
        log.set_deadline(20.0)
        forward = StageProgress(log)
        for stage, lasts in stages:
            forward(Progress(stage, begins[stage]))
            clock.advance(lasts)
            log.tell_time()
            assert told(context)[-1] < max(ends[name] for name, _ in stages)
    assert told(context) == sorted(told(context))


def test_the_stages_of_a_plan_say_where_they_end() -> None:
    seen: list[Progress] = []
    forward = StageProgress(seen.append)
    for stage in ("goals", "search", "refine", "certify", "search", "certify"):
        forward.begin(stage)
    assert [(one.stage, one.fraction, one.until) for one in seen[1:]] == [
        ("search", 0.15, 0.5),
        ("refine", 0.5, 0.6),
        ("certify", 0.8, 0.95),
        ("search", 0.8, 0.8),
        ("certify", 0.8, 0.95),
    ]


def test_the_best_path_comes_with_the_seconds_since_the_beginning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, context = FakeClock(now=100.0), TaskContext()
    monkeypatch.setattr("time.monotonic", clock)
    log = ProgressReporter(context)
    clock.advance(1.5)
    log(Progress("search", 0.15, "found", path_of(2.5, np.empty((0, 2)))))
    data = {"detail": "found", "length": 2.5, "seconds": 1.5}
    assert context.events == [("best-so-far", data)]


@pytest.mark.parametrize("count", [2, 64, 65, 1000])
def test_a_long_best_path_is_told_by_some_of_its_waypoints(count: int) -> None:
    waypoints = rng_of(count).normal(size=(count, 3)).cumsum(axis=0)
    context = TaskContext()
    ProgressReporter(context)(Progress("search", 0.15, "found", path_of(9.0, waypoints)))
    ((_, data),) = context.events
    told = np.array(data["waypoints"])
    assert len(told) == min(count, MAX_BEST_WAYPOINTS)
    np.testing.assert_allclose(told[[0, -1]], waypoints[[0, -1]], atol=1e-6)
    near = np.abs(told[:, None] - waypoints[None]).max(axis=2)
    rows = near.argmin(axis=1)
    assert near.min(axis=1).max() < 1e-6
    assert (np.diff(rows) > 0).all()
    assert np.diff(rows).max() <= np.ceil(count / (MAX_BEST_WAYPOINTS - 1))


def path_of(length: float, waypoints: np.ndarray) -> BestPath:
    return BestPath(AttemptReport("RRTstar", "improving", length, length, length, 0), waypoints)
