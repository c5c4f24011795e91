"""An execution looks at what is asked of it by the clock on the wall, whatever its speed."""

from contextlib import nullcontext
from dataclasses import dataclass, field
from itertools import pairwise
from types import SimpleNamespace

import pytest

from planning.errors import TrackingLost
from planning.execute.execution import Execution
from planning.execute.runner import Runner
from service.executions import worker
from service.executions.worker import MAX_SILENCE, TICK, follow
from tests.clocks import FakeClock
from tests.execute.conftest import EchoDriver, limits, quintic
from tests.profiles import only_campaign

# What a step of the simulation takes on the wall [s].
COST = 0.003


@dataclass
class TaskContext:
    """Asks for the end after so many looks; notes when it was looked at, and what it was told."""

    clock: FakeClock
    looks_left: int = 10**9
    asked: list = field(default_factory=list)
    looks: list = field(default_factory=list)
    told: list = field(default_factory=list)
    silence: float = 0.0

    def is_canceled(self):
        self.looks.append(self.clock.now)
        self.looks_left -= 1
        return self.looks_left < 0

    def controls(self):
        return self.asked.pop(0) if self.asked else {}

    def emit(self, _, data):
        self.told.append((self.clock.now, data))

    def update(self, _, data):
        self.told.append((self.clock.now, data))

    def watch(self, silence):
        self.silence = silence


class SlowDriver(EchoDriver):
    """Takes time on the wall for every step."""

    def read(self, time):
        CLOCK.advance(COST if self.sent else 0.0)
        return super().read(time)


CLOCK = FakeClock()


def followed(channel, speed, duration=200.0):
    runner = Runner(Execution(quintic(duration), limits()), SlowDriver())
    runner.set_speed(speed)
    return follow(runner, channel, speed, CLOCK, CLOCK.advance)


FURTHER = only_campaign("slow, fast and twice as fast show it")


@pytest.mark.campaign
@pytest.mark.parametrize(
    "speed",
    [0.5, 2.0, 100.0, pytest.param(1.0, marks=FURTHER), pytest.param(10.0, marks=FURTHER)],
)
def test_a_look_is_never_further_away_than_a_tick_and_a_step(speed):
    channel = TaskContext(CLOCK, looks_left=200)
    last = followed(channel, speed)
    assert last.state == "canceled"
    assert 0 < last.progress < 1
    gaps = [b - a for a, b in pairwise(channel.looks)]
    assert len(gaps) == 200
    assert max(gaps) <= TICK + COST + 1e-9
    # To rest on the path and to stand still takes the robot 0.2 s of its own clock at most.
    assert CLOCK.now - channel.looks[-1] <= 0.2 / 0.004 * COST + 2 * TICK + 0.1 / min(speed, 1.0)


def test_it_says_how_it_goes_more_often_than_it_may_be_silent():
    channel = TaskContext(CLOCK, asked=[{"is_paused": True}] * 200 + [{"is_paused": False}])
    last = followed(channel, 100.0, 4.0)
    assert last.state == "succeeded"
    assert channel.silence == MAX_SILENCE
    times = [at for at, _ in channel.told]
    assert max(b - a for a, b in pairwise(times)) < MAX_SILENCE / 10
    assert "paused" in {data["state"] for _, data in channel.told}


def test_what_is_asked_is_done_once_and_in_any_combination():
    asked = [{}, {"is_paused": True}, {"is_paused": True, "speed": 4.0}]
    asked += [{"is_paused": True}] * 20 + [{"is_paused": False}]
    channel = TaskContext(CLOCK, asked=asked)
    assert followed(channel, 0.5, 2.0).state == "succeeded"
    states = list(dict.fromkeys(data["state"] for _, data in channel.told))
    assert states == ["executing", "paused", "succeeded"]


@pytest.mark.parametrize("delay", [0.0, 0.7])
def test_it_says_how_late_it_was(delay):
    """The longest delay counts, whether it was in a wait or in a step of the simulation."""
    delays = iter([0.3 * delay, delay, 0.5 * delay])

    def wait(seconds):
        CLOCK.advance(seconds + next(delays, 0.0))

    channel = TaskContext(CLOCK)
    runner = Runner(Execution(quintic(2.0), limits()), SlowDriver())
    last = follow(runner, channel, 1.0, CLOCK, wait)
    assert delay - 1e-9 <= last.lateness <= delay + COST + 1e-9
    assert channel.told[0][1]["lateness"] == 0.0


def test_one_that_fails_tells_its_stage_and_the_seconds_of_all(monkeypatch):
    runner = Runner(Execution(quintic(2.0), limits()), EchoDriver())
    monkeypatch.setattr(worker, "borrow_world", lambda work: nullcontext())
    monkeypatch.setattr(worker, "_runner", lambda world, work: (runner, EchoDriver(), None))

    def follow_until_it_is_lost(*_, **__):
        runner.execution = runner.execution.fail(TrackingLost("the robot is elsewhere"))

    monkeypatch.setattr(worker, "follow", follow_until_it_is_lost)
    context = TaskContext(CLOCK)
    with pytest.raises(TrackingLost) as failure:
        worker.execute(SimpleNamespace(speed=1.0), context)
    assert failure.value.stage == "execute"
    assert set(failure.value.timings) == {"load", "execute", "total"}
    stages = [data for _, data in context.told]
    assert [data["stage"] for data in stages] == ["load", "execute"]
    assert set(stages[-1]["timings"]) == {"load"}
