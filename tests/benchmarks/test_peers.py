"""Other planners: their process, the curve of their setpoints, how it is judged, and their rows."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import mbm
from benchmarks.motion_bench_maker.limits import peak_rate
from benchmarks.motion_bench_maker.peers.process import PeerLost, PeerMissing, PeerProcess
from benchmarks.motion_bench_maker.peers.roboplan import RoboplanPeer
from benchmarks.motion_bench_maker.peers.side_by_side import peer_documents, print_side_by_side
from benchmarks.motion_bench_maker.problems import Problem, read_problems
from benchmarks.motion_bench_maker.referee import Polynomials, Referee
from benchmarks.motion_bench_maker.robots import ROBOTS, robot_files
from benchmarks.motion_bench_maker.runs import Run, Runs

# Moves by setpoints along the straight line in joint space, in the seconds that it is told.
LINE = """
import json, sys
print(json.dumps({"name": "line", "version": "1"}), flush=True)
for text in sys.stdin:
    asked = json.loads(text)
    if asked["step"] < 0.01:
        told = {"fault": "it was too fine"}
    else:
        n, T = 401, float(sys.argv[1])
        line = [(a, b - a) for a, b in zip(asked["start"], asked["goal"])]
        s = [i / (n - 1) for i in range(n)]
        told = {
            "fault": "",
            "times": [T * x for x in s],
            "positions": [[a + d * (3 * x * x - 2 * x**3) for a, d in line] for x in s],
            "velocities": [[d * 6 * (x - x * x) / T for _, d in line] for x in s],
        }
    print(json.dumps({**told, "wall_ms": 3.0, "cpu_ms": 2.0}), flush=True)
"""


def line(seconds: float) -> PeerProcess:
    return PeerProcess([sys.executable, "-c", LINE, str(seconds)], "install it")


def run(models: Path, file: Path, seconds: float, step: float = 0.05) -> Run:
    files = robot_files(models, ROBOTS["panda"])
    problem = read_problems(file, "panda")[0]
    assert Referee(files, problem).is_valid
    with line(seconds) as process:
        peer = RoboplanPeer(process.name, process, files, step, "cpu")
        return peer.run(problem, "joint", Referee(files, problem))


def test_setpoints_are_joined_by_a_curve_with_their_positions_and_velocities() -> None:
    rng = np.random.default_rng(3)
    times = np.cumsum(rng.uniform(0.01, 0.5, 9))
    q, v = rng.normal(size=(2, 9, 3))
    curve = Polynomials.through(("a", "b", "c"), times, q, v)
    assert np.allclose(curve.velocities(times), v)
    samples = curve.samples(10.0)  # at pieces' ends, and more
    assert all(np.isclose(samples, one).all(axis=1).any() for one in q)
    # By finite differences between the setpoints as well.
    at = (times[:-1] + times[1:]) / 2
    local = (at - times[:-1])[:, None, None]
    powers = np.arange(4)[None, :, None]
    places = [
        (curve.coefficients * (local + nudge) ** powers).sum(axis=1) for nudge in (-1e-6, 1e-6)
    ]
    assert np.allclose((places[1] - places[0]) / 2e-6, curve.velocities(at), atol=1e-6)


@pytest.mark.parametrize("over", [0.5, 1.0, 1.7])
def test_the_peak_rate_is_how_far_a_motion_is_over_its_limits(over: float) -> None:
    # Half a second at a constant acceleration, to a speed of `over`, and back.
    times, rising = np.linspace(0.0, 1.0, 101), over * np.linspace(0.0, 1.0, 51)
    v = np.append(rising, rising[-2::-1])[:, None]
    q = np.concatenate([[[0.0]], np.cumsum((v[1:] + v[:-1]) / 2 * 0.01, axis=0)])
    motion = Polynomials.through(("a",), times, q, v)
    assert peak_rate(motion, np.array([1.0]), np.array([100.0])) == pytest.approx(over)
    assert peak_rate(motion, np.array([100.0]), np.array([2.0])) == pytest.approx(over)


def test_what_a_peer_delivers_is_judged_like_ours(models: Path, problem_file: Path) -> None:
    found = run(models, problem_file, seconds=2.0)
    assert found.solved
    assert found.free
    assert found.total_ms == 2.0  # of the clock that was asked for
    # Joint 1 turns by 1.4 rad, others rest: 1.5 times the mean speed at the middle.
    assert found.length == pytest.approx(1.4, abs=1e-6)
    assert found.peak_rate == pytest.approx(1.5 * 0.7 / 2.175, rel=1e-3)
    assert run(models, problem_file, seconds=0.5).peak_rate > 1.5


def test_a_motion_through_an_obstacle_is_not_free(models: Path, problem_file: Path) -> None:
    documents = json.loads(problem_file.read_text())
    documents[0]["objects"][0] |= {"pos": [0.35, 0.0, 0.5], "dims": [0.04, 0.04, 1.0]}
    problem_file.write_text(json.dumps(documents))
    found = run(models, problem_file, seconds=2.0)
    assert found.solved
    assert not found.free


def test_why_a_peer_failed_is_told(models: Path, problem_file: Path) -> None:
    found = run(models, problem_file, seconds=2.0, step=0.005)
    assert (found.solved, found.detail, found.total_ms) == (False, "it was too fine", 2.0)


def test_a_peer_that_ends_is_lost() -> None:
    greeting = json.dumps({"name": "short", "version": "1"})
    code = f"print('{greeting}', flush=True); input(); raise SystemExit(3)"
    with PeerProcess([sys.executable, "-c", code], "install it") as process:
        assert process.name == "short 1"
        with pytest.raises(PeerLost, match="3"):
            process.ask({})


@pytest.mark.parametrize("command", [["/no/such/python"], [sys.executable, "-c", "pass"]])
def test_what_cannot_begin_says_how_to_install_it(command: list[str]) -> None:
    with pytest.raises(PeerMissing, match="put it there"):
        PeerProcess(command, "put it there")


def test_without_the_wheel_the_command_says_how_to_install_it(
    models: Path, problem_file: Path
) -> None:
    # This environment has roboplan's models for other tests, and no planner, as it should.
    files = ("--problems", str(problem_file), "--models", str(models))
    asked = ("--peers", "roboplan", "--peer-python", sys.executable)
    with pytest.raises(SystemExit) as ended:
        mbm.run(mbm.parser().parse_args([*files, *asked]), 0)
    assert "'roboplan.core'" in ended.value.code
    assert "make bench-peers" in ended.value.code
    assert len(ended.value.code.splitlines()) == 1


def test_rows_of_a_run_stand_beside_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    problem = Problem("a", 1, (), (), (), ())
    ours = Run(problem, "joint", 4.0, 4.0, duration=2.0, length=3.0, free=True, peak_rate=1.0)
    fast = replace(ours, peak_rate=1.02)
    lost = replace(ours, failure="not_solved", detail="none found", free=False)
    done = Runs([problem], [], [ours], [], {"peer 1": [fast, replace(ours, free=False), lost]})
    print_side_by_side(done, ["none"])
    told = capsys.readouterr().out
    lines = [text.strip() for text in told.splitlines()]
    rows = [text.split() for text in lines if text.startswith(("Wayproof", "peer 1 "))]
    assert rows[0][3:10] == ["1", "of", "1", "1", "1", "1", "1.000"]
    assert rows[1][2:9] == ["2", "of", "3", "1", "1", "0", "1.020"]
    assert "peer 1: a 1, joint goal, not solved: none found" in told
    assert peer_documents(done)["peer 1"]["joint"]["solved"] == "2 of 3"
