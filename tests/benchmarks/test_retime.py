"""The retiming benchmark: its judge sees what is wrong, and every contender has its row."""

import numpy as np
import pytest

import planning.retime.toppra.toppra_passes  # noqa: F401 - silences what Python says of toppra's docstrings
from benchmarks.retime import measured, summary
from benchmarks.retiming.contenders import CONTENDERS, YARDSTICKS, ours
from benchmarks.retiming.judge import Verdict, deviation, judged
from benchmarks.retiming.motion import Motion
from benchmarks.retiming.paths import Question, random_paths
from benchmarks.retiming.sampled import COUNTS, sampled
from tests.profiles import PROFILE


@pytest.fixture(scope="module")
def questions() -> list[Question]:
    return random_paths(2, seed=3)


def sound(question: Question) -> Motion:
    motion = ours("toppra", 0.1)(question)()
    assert motion is not None
    return motion


def verdict(question: Question, motion: Motion | None) -> Verdict:
    return judged(question, motion, 1.0, jerk=False)


def test_paths_are_the_same_for_the_same_seed_and_within_limits(questions: list[Question]) -> None:
    assert [question.robot for question in questions] == ["panda", "ur5e"]
    again = random_paths(2, seed=3)
    for question, same in zip(questions, again, strict=True):
        np.testing.assert_array_equal(question.path.waypoints, same.path.waypoints)
        assert 3 <= len(question.path.waypoints) <= 8
        assert (question.path.waypoints <= question.limits.upper).all()
        assert (question.path.waypoints >= question.limits.lower).all()


def test_the_judge_sees_speed_ends_gaps_and_ways_off(questions: list[Question]) -> None:
    question = questions[0]
    motion = sound(question)
    found = verdict(question, motion)
    assert found.valid
    assert 0.999 < found.use < 1 + 1e-6
    assert 0.01 < found.deviation <= 0.1
    twice = Motion(
        motion.duration / 2,
        lambda t: [x * 2.0**k for k, x in enumerate(motion.sample(2 * t))],
    )
    assert verdict(question, twice).use > 3.9
    short = Motion(motion.duration * 0.9, motion.sample)
    assert not verdict(question, short).valid
    broken = Motion(motion.duration, lambda t: [x * np.nan for x in motion.sample(t)])
    assert not verdict(question, broken).valid
    assert not verdict(question, None).valid

    def wide(t: np.ndarray) -> list[np.ndarray]:
        q, *rates = motion.sample(t)
        return [q + 0.3 * np.sin(np.pi * t / motion.duration)[:, None], *rates]

    assert verdict(question, Motion(motion.duration, wide)).deviation > found.deviation + 0.1


def test_deviation_is_the_distance_from_the_polyline() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    on = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.3]])
    assert deviation(on, corner) == pytest.approx(0.0, abs=1e-12)
    assert deviation(np.array([[0.5, 0.2], [1.3, 1.4]]), corner) == pytest.approx(0.5)


@pytest.mark.filterwarnings("ignore")
def test_every_contender_has_its_row_and_ours_keep_their_limits(questions: list[Question]) -> None:
    told = summary(measured(questions))
    assert set(told) == set(CONTENDERS) == set(YARDSTICKS)
    for name, row in told.items():
        assert row["valid"] == 1.0
        assert row["ms"]["median"] > 0
        if name.startswith("ours"):
            assert row["within"] == 1.0
            assert row["deviation"]["worst"] <= 0.1
            assert row["ratio"] >= 1.0 - 1e-9
    assert told["ours, toppra, corners kept"]["deviation"]["worst"] < 1e-6


@pytest.mark.campaign
def test_how_finely_a_path_is_sampled_matters_little(questions: list[Question]) -> None:
    counts = COUNTS if PROFILE.is_campaign else (10, 50)
    rows = sampled(questions[:1], 1, counts)
    assert [row.count for row in rows] == 2 * [count for count in counts for _ in range(2)]
    for kind in ("curve", "line"):
        for method in ("toppra", "ruckig"):
            some = [row.duration_s for row in rows if (row.kind, row.method) == (kind, method)]
            assert max(some) < (1.1 if kind == "curve" else 1 + 1e-6) * min(some)
