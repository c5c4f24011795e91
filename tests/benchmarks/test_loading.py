"""benchmarks/loading.py end to end, on small scenes of each kind."""

import json
from itertools import chain

import pytest

import planning
from benchmarks import loading
from tests.clocks import FakeClock
from tests.profiles import PROFILE, only_campaign

# A row takes a process of its own, and a second; scenes of all kinds are measured below.
SIZES = {"boxes": [3, 60], "robots": [2], "frames": [5]}
if not PROFILE.is_campaign:
    SIZES = {"boxes": [3], "robots": [2], "frames": []}


@only_campaign("5 s")
@pytest.mark.campaign
def test_every_scene_has_its_row(capsys: pytest.CaptureFixture[str]) -> None:
    asked = [[f"--{kind}", *map(str, counts)] for kind, counts in SIZES.items()]
    loading.main([*chain(*asked), "--json"])
    rows = json.loads(capsys.readouterr().out)
    assert list(rows) == [f"{count} {kind}" for kind in SIZES for count in SIZES[kind]]
    for row in rows.values():
        assert list(row) == list(loading.COLUMNS)
        assert all(number > 0 for number in row.values())


@pytest.mark.parametrize(("kind", "count"), [("boxes", 60), ("robots", 2), ("frames", 30)])
def test_steps_are_told_apart(kind: str, count: int) -> None:
    row = loading.measured(loading.KINDS[kind](count), FakeClock(step=1.0))
    assert [row[column] for column in loading.COLUMNS[:-1]] == [1.0] * 5


def test_nothing_collides_in_its_scenes() -> None:

    for document in (loading.boxes(300), loading.robots(3)):
        world = planning.load_world(planning.parse_scene(document))
        group = world.groups[0]
        q = world.positions(group)[None]
        assert planning.check_configurations(world, group.name, q)[0].valid
