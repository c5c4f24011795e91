"""Durations of arc segments compared with those of the retimers."""

import numpy as np
import pytest

from planning.domain.curves.path import JointPath
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointType
from planning.domain.robot.steering import Steering, manifold_of, steered
from planning.refine.cars.segment_times import SegmentTimes
from planning.retime.retimer import retime
from tests.search.conftest import group_of, limits_of

GROUP = steered(
    group_of(JointType.REVOLUTE, JointType.PLANAR, JointType.REVOLUTE), {"r::j1": Steering(0.3)}
)


@pytest.mark.parametrize(
    ("method", "short", "long"), [("toppra", 0.97, 1.01), ("ruckig", 0.8, 1.1)]
)
def test_segments_take_as_long_as_with_the_retimer(method: str, short: float, long: float) -> None:
    limits = limits_of(GROUP)
    times = SegmentTimes.of(limits, 1, limits_jerk=method == "ruckig")
    rng = np.random.default_rng(4)
    for _ in range(8):
        length = 10 ** rng.uniform(-2.5, 0.2) * rng.choice([-1, 1])
        turn = np.clip(length * rng.uniform(-1, 1) / 0.3, -2.5, 2.5) * rng.choice([0, 1, 1])
        moves = rng.uniform(-0.6, 0.6, 2) * rng.choice([0, 1])
        q0 = np.zeros(5)
        q1 = manifold_of(GROUP).plus(q0, np.array([moves[0], length, 0.0, turn, moves[1]]))
        path = JointPath(GROUP, np.stack([q0, q1]))
        timed, _ = retime(path.spline, limits, RetimeOptions(method=method))
        found = times.durations(np.array([length]), np.array([turn]), moves[None])[0]
        assert short < found / timed.duration < long


def test_shorter_segments_take_less_time_but_more_per_metre() -> None:
    times = SegmentTimes.of(limits_of(GROUP), 1, limits_jerk=False)
    lengths = np.linspace(0.0, 1.0, 30)
    durations = times.durations(lengths, lengths / 0.3, np.zeros((30, 2)))
    assert durations[0] == pytest.approx(0.0, abs=1e-5)
    assert (np.diff(durations) > 0).all()
    assert (np.diff(durations, 2) < 1e-3 * durations[-1]).all()


def test_joints_that_move_while_the_car_stands_take_time() -> None:
    limits = limits_of(GROUP)
    times = SegmentTimes.of(limits, 1, limits_jerk=False)
    alone = times.durations(np.zeros(1), np.zeros(1), np.array([[0.5, 0.0]]))[0]
    together = times.durations(np.array([0.01]), np.zeros(1), np.array([[0.5, 0.0]]))[0]
    assert alone > 0.1
    assert together == pytest.approx(alone)
