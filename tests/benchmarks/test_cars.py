"""benchmarks/cars.py end to end, on one problem of each kind."""

import json

import numpy as np
import pytest

from benchmarks import cars
from benchmarks.car_problems.yards import yard
from tests.clocks import FakeClock


def test_json_has_durations_before_and_after(capsys: pytest.CaptureFixture[str]) -> None:
    cars.main(["--seeds", "1", "--yards", "1", "--json"], FakeClock())
    told = json.loads(capsys.readouterr().out)
    assert len(told) == 5
    runs = [run for rows in told.values() for run in rows if run is not None]
    assert len(runs) == 5
    for run in runs:
        assert 0 < run["after"] <= run["before"]
        assert run["stops"][1] <= run["stops"][0]


def test_yards_are_what_their_seed_says_and_leave_room_for_the_car() -> None:
    one, same, other = (yard(seed, reverse=True) for seed in (3, 3, 5))
    assert one.world.state.tobytes() == same.world.state.tobytes() != other.world.state.tobytes()
    group = one.world.group("car")
    oracle = one.world.collision_oracle(group, one.world.margins())
    ends = np.stack([one.world.positions(group), *one.goal.positions])
    assert oracle.are_free(ends).all()
