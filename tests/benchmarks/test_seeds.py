"""benchmarks/seeds.py end to end, and every motion of the picking cycle judged anew."""

import json

import numpy as np
import pytest

import planning
from benchmarks import seeds as command
from benchmarks.seed_scenes.cycle import pick_and_place
from benchmarks.seed_scenes.seeds import SEEDS
from tests.clocks import FakeClock, no_hurry
from tests.conftest import bundled_world
from tests.profiles import PROFILE, only_campaign

# The others take a second or two each; the picking cycle is judged below.
NAMES = [seed.name for seed in SEEDS] if PROFILE.is_campaign else ["window_3d", "ur5e_pickup_joint"]


@pytest.mark.campaign
def test_json_counts_runs_and_seconds_of_every_seed(capsys: pytest.CaptureFixture[str]) -> None:
    status = command.main(["--runs", "2", "--only", *NAMES, "--json"], FakeClock(step=1e-6))
    told = capsys.readouterr()
    report = json.loads(told.out)
    assert list(report) == NAMES
    for row in report.values():
        assert (row["runs"], row["solved"], row["proven"]) == (2, 2, 2), told.err
        assert row["seconds"]["max"] >= row["seconds"]["median"] > 0
    assert status == 0


def test_a_failure_is_counted_told_and_ends_with_1(capsys: pytest.CaptureFixture[str]) -> None:
    def unsolvable(world: planning.World, seed: int, deadline: planning.Deadline):
        goal = planning.JointGoal(np.array([[0.3, -0.2, 0.0]]))  # in a wall
        planning.plan(planning.PlanningProblem("body", goal), world, deadline=deadline)
        raise AssertionError

    seed = command.Seed("maze_2d", "maze_2d", 4.0, unsolvable)
    assert command.main(["--runs", "2", "--json"], FakeClock(), (seed,)) == 1
    told = capsys.readouterr()
    row = json.loads(told.out)["maze_2d"]
    assert (row["runs"], row["solved"], row["proven"]) == (2, 0, 0)
    assert told.err.count("goal_in_collision") == 2


@only_campaign("6 s")
def test_the_part_gets_into_the_tray_and_nothing_touches_on_the_way() -> None:
    start = bundled_world("irb120_cell")
    deadline = no_hurry(60.0)
    legs = pick_and_place(start, 1, deadline)
    carried = [leg.world.drake.owners for leg in legs]
    assert carried == [{}, {"part": "arm"}, {"part": "arm"}, {}]
    last = start.positions(start.group("arm"))
    for leg in legs:
        judge = planning.load_world(leg.world.scene, kernel=False)
        group = judge.group("arm")
        motion = leg.plan.trajectory
        assert leg.plan.certificate.proven
        np.testing.assert_array_equal(motion.start, last)
        last = leg.plan.goal_configuration
        for q in motion.positions(motion.sample_times(0.02)):
            assert not judge.violations(group, q, judge.margins())
    placed = legs[-1].world
    x_wp = placed.frame_pose("part", placed.state)
    wanted = planning.Pose.from_parts((0.36, -0.22, 0.0305))
    shift, turn = x_wp.distance(wanted)
    assert shift < 1e-3
    # a square part may lie in the tray by any quarter turn
    assert min(abs(turn - k * np.pi / 2) for k in range(3)) < 1e-3
