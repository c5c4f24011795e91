"""Methods of refinement beside each other: what is counted, and over which problems."""

import argparse
import json
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import mbm
from benchmarks.motion_bench_maker import loads
from benchmarks.motion_bench_maker.command import bench
from benchmarks.motion_bench_maker.comparison import print_comparison
from benchmarks.motion_bench_maker.problems import Problem
from benchmarks.motion_bench_maker.robots import ROBOTS
from benchmarks.motion_bench_maker.runs import Method, Run, Runs
from tests.clocks import FakeClock
from tests.profiles import only_campaign


def run(method: Method, index: int, **changes: object) -> Run:
    motion = Run(
        Problem("cage", index, (), (), (), ()),
        "joint",
        10.0,
        10.0,
        stages_ms={"refine": 4.0},
        free=True,
        lower_bound=1.0,
        method=method,
    )
    return replace(motion, **changes)


def test_numbers_are_of_the_problems_that_every_method_solved(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runs = [
        run("none", 1, duration=2.0),
        run("none", 2, duration=3.0),
        run("none", 3, duration=9.0),
        run("drake", 1, duration=1.5, improved=True),
        run("drake", 2, duration=2.5, improved=True, free=False),
        run("drake", 3, failure="deadline_exceeded", detail="late"),
    ]
    print_comparison(Runs([], [], runs, []), ("none", "drake"), "head")
    printed = capsys.readouterr().out
    rows = {words[0]: words for words in map(str.split, printed.splitlines()) if words}
    assert rows["none"][1:7] == ["3", "of", "3", "3", "0", "2.50"]
    assert rows["drake"][1:7] == ["2", "of", "3", "1", "2", "2.00"]
    assert "not solved: cage 3, joint goal, refine drake: deadline_exceeded" in printed
    assert "NOT FREE: cage 2, joint goal, refine drake" in printed


def test_reasons_are_counted_without_their_instants(capsys: pytest.CaptureFixture[str]) -> None:
    where = "the curve violates a margin at path parameters s = "
    runs = [run("drake", 1, reason=where + "0.1"), run("drake", 2, reason=where + "0.7")]
    print_comparison(Runs([], [], runs, []), ("drake",), "head")
    assert "drake: 2 times: the curve violates a margin\n" in capsys.readouterr().out


def test_the_command_takes_several_methods_and_weights() -> None:
    words = ["--refine", "none,drake", "--objective", "smoothness=0.1,duration"]
    options = mbm.parser().parse_args(words)
    assert options.refine == ("none", "drake")
    assert options.objective == {"smoothness": 0.1, "duration": 1.0}


@pytest.mark.parametrize(
    "words", [["--refine", "chomp"], ["--objective", "beauty=1"], ["--loads", "wind"]]
)
def test_what_is_unknown_is_refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises((SystemExit, argparse.ArgumentTypeError)):
        mbm.parser().parse_args(words)
    assert "it must be of" in capsys.readouterr().err


def test_loads_have_rows_of_their_own(capsys: pytest.CaptureFixture[str]) -> None:
    runs = [
        run("trajopt", 1, duration=2.0),
        run("trajopt", 1, duration=5.0, load="torque", free=False),
        run("trajopt", 2, duration=1.0),
        run("trajopt", 2, load="torque", failure="deadline_exceeded", detail="late"),
    ]
    print_comparison(Runs([], [], runs, []), ("trajopt",), "head", ("none", "torque"))
    printed = capsys.readouterr().out
    rows = [line.split() for line in printed.splitlines() if line.startswith(" trajopt")]
    assert [row[:2] for row in rows] == [["trajopt", "2"], ["trajopt,", "torque"]]
    assert rows[0][1:7] == ["2", "of", "2", "2", "0", "2.00"]
    assert rows[1][2:8] == ["1", "of", "2", "0", "0", "5.00"]
    assert "not solved: cage 2, joint goal, refine trajopt, torque: deadline_exceeded" in printed


def test_the_commands_loads_are_those_of_the_plans() -> None:
    assert mbm.LOADS == loads.LOADS
    assert mbm.parser().parse_args(["--loads", "torque,all"]).loads == ("torque", "all")


def test_each_load_limits_what_its_name_says() -> None:
    options = {load: loads.retime_options(ROBOTS["panda"], load) for load in loads.LOADS}
    claims = {
        load: (o.effort and o.payload is not None, bool(o.tool_limits), bool(o.speed_zones))
        for load, o in options.items()
    }
    assert claims == {
        "none": (False, False, False),
        "torque": (True, False, False),
        "tool": (False, True, False),
        "zone": (False, False, True),
        "all": (True, True, True),
    }
    assert loads.retime_options(ROBOTS["ur5"].with_jerk(500), "zone").method == "ruckig"


@only_campaign("9 s")
def test_every_method_plans_every_problem(
    models: Path, problem_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = ("--problems", str(problem_file), "--models", str(models), "--json")
    options = mbm.parser().parse_args([*files, "--refine", "none,drake"])
    bench(options, 0, FakeClock(step=1e-6))
    documents = json.loads(capsys.readouterr().out)
    assert set(documents) == {"none", "drake"}
    for part in documents.values():
        assert [part[key] for key in ("problems", "valid", "solved", "free")] == [2, 1, 1, 1]
    shorter, longer = (documents[name]["duration_s"]["median"] for name in ("drake", "none"))
    assert shorter <= longer
