"""Round robin, percentiles and ratios."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.motion_bench_maker.bounds import print_bounds
from benchmarks.motion_bench_maker.limits import least_duration
from benchmarks.motion_bench_maker.peers.earlier import print_peers
from benchmarks.motion_bench_maker.problems import Problem, round_robin
from benchmarks.motion_bench_maker.runs import Run, Runs
from benchmarks.motion_bench_maker.summary import Spread, document, ratio


def problem(name: str, index: int) -> Problem:
    return Problem(name, index, (), (), (), ())


def run(name: str, index: int, total: float, failure: str = "") -> Run:
    return Run(problem(name, index), "joint", total, total, failure=failure, free=not failure)


def test_round_robin_takes_one_of_each_set_in_turn() -> None:
    given = [problem("a", 1), problem("a", 2), problem("a", 3), problem("b", 1), problem("c", 1)]
    given.append(problem("c", 2))
    assert [p.name for p in round_robin(given)] == ["a 1", "b 1", "c 1", "a 2", "c 2", "a 3"]


def test_spread_of_a_hundred_and_one_numbers() -> None:
    spread = Spread.of([float(number) for number in reversed(range(101))])
    assert spread == Spread(50.0, 50.0, 95.0)
    assert Spread.of([0.0, 2.0]) == Spread(1.0, 1.0, 1.9)
    assert Spread.of([]) is None


def test_failed_plans_count_in_total_with_their_time() -> None:
    runs = [run("a", 1, 10.0), run("a", 2, 5000.0, "deadline_exceeded")]
    done = Runs([r.problem for r in runs] + [problem("a", 3)], [problem("a", 3)], runs, [1.0])
    found = document(done, None)
    counts = [found[key] for key in ("problems", "valid", "solved", "free")]
    assert counts == [3, 2, 1, 1]
    assert found["total_ms"]["mean"] == 2505.0
    assert found["failures"] == [{"problem": "a 2", "code": "deadline_exceeded"}]


def test_what_refinement_made_quicker_and_what_nothing_beats() -> None:
    runs = [
        replace(run("a", 1, 10.0), improved=True, duration=2.0, lower_bound=1.0),
        replace(run("a", 2, 10.0), duration=3.0, lower_bound=2.0),
        run("a", 3, 10.0, "no_path_found"),
    ]
    found = document(Runs([r.problem for r in runs], [], runs, [1.0]), None)
    assert found["improved"] == 0.5
    assert found["lower_bound_s"]["median"] == 1.5
    second = {"problem": "a 2", "duration_s": 3.0, "lower_bound_s": 2.0, "improved": False}
    assert found["bounds"][1] == second


def test_a_table_has_the_bound_of_every_problem(capsys: pytest.CaptureFixture[str]) -> None:
    runs = [
        replace(run("b", 10, 10.0), duration=3.0, lower_bound=2.5),
        replace(run("b", 9, 10.0), improved=True, duration=2.0, lower_bound=2.0),
        replace(run("b", 9, 10.0), goal="pose", duration=1.5, lower_bound=1.0),
        run("a", 1, 10.0, "no_path_found"),
    ]
    print_bounds(Runs([], [], runs, []))
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [row for row in rows if row and row[0] in {"a", "b"}] == [
        ["a", "1", *"--------"],
        ["b", "9", "2.000", "2.000", "1.000", "yes", "1.500", "1.000", "1.500", "no"],
        ["b", "10", "3.000", "2.500", "1.200", "no", *"----"],
    ]


def test_the_slowest_joint_bounds_the_duration() -> None:
    moved, velocity, acceleration = np.array([0.1, -3.0]), np.array([1.0, 2.0]), np.full(2, 4.0)
    assert least_duration(moved, velocity, acceleration) == pytest.approx(3.0 / 2 + 2 / 4)
    assert least_duration(moved / 4, velocity, acceleration) == pytest.approx(2 * (0.75 / 4) ** 0.5)


def test_jerk_bounds_the_duration_too() -> None:
    moved, velocity, acceleration = np.array([1.0, 0.1]), np.full(2, 10.0), np.full(2, 1e3)
    # From rest to rest by four phases of constant jerk: d = 2 j (T / 4)^3.
    wanted = 4 * (1.0 / (2 * 500.0)) ** (1 / 3)
    found = least_duration(moved, velocity, acceleration, np.full(2, 500.0))
    assert found == pytest.approx(wanted)
    assert least_duration(moved, velocity, acceleration, np.full(2, 1e9)) == pytest.approx(
        least_duration(moved, velocity, acceleration), rel=1e-2
    )


def test_ratio_is_taken_on_the_same_problems() -> None:
    ours = [run("a", 1, 10.0), run("b", 1, 20.0), run("a", 2, 9000.0)]
    theirs = [run("a", 1, 50.0), run("b", 1, 100.0)]
    assert ratio(Runs([], [], ours, []), Runs([], [], theirs, []), "joint") == 5.0


def test_others_stand_beside_a_run_of_the_robot_that_they_were_measured_with(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runs = [replace(run("a", 1, 12.0), duration=2.0, length=3.0), run("a", 2, 7.0, "no_path_found")]
    done = Runs([r.problem for r in runs], [], runs, [])
    print_peers(done, "ur5", "none")
    assert capsys.readouterr().out == ""
    print_peers(done, "panda", "none")
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    (ours,) = (row for row in rows if row[:2] == ["this", "run,"])
    (theirs,) = (row for row in rows if row[:1] == ["mplib"])
    assert ours[4:] == ["1", "of", "2", "9.5", "/", "9.5", "/", "11.8", "2.00", "3.00", "100", "%"]
    assert theirs[-4:] == ["1.97", "4.68", "14", "%"]
