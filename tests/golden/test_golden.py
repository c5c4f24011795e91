"""The golden set covers what it says, and its digests tell what matters from what does not."""

import json
from pathlib import Path

from tests.golden.__main__ import compare, digest_of, lasting
from tests.golden.plans import plans

SCENES = Path(__file__).parents[2] / "scenes"


def test_every_bundled_scene_and_type_of_goal_is_planned_under_a_name_of_its_own():
    names, scenes, requests = zip(*plans(), strict=True)
    assert len(set(names)) == len(names)
    assert set(scenes) == {
        file.name.removesuffix(".scene.yaml") for file in SCENES.glob("*.scene.yaml")
    }
    types = {"joint", "configuration", "pose", "region", "relative", "line", "path"}
    assert {request["goal"]["type"] for request in requests} == types


def test_ids_and_times_change_no_digest_and_numbers_do():
    answer = {"id": "a", "result": {"timings": {"total": 1.0}, "times": [0.0, 0.1]}}
    again = {"id": "b", "result": {"timings": {"total": 2.0}, "times": [0.0, 0.1]}}
    other = {"id": "a", "result": {"timings": {"total": 1.0}, "times": [0.0, 0.1 + 1e-16]}}
    assert digest_of(lasting(answer)) == digest_of(lasting(again)) != digest_of(lasting(other))


def test_what_differs_is_named_and_counted(tmp_path, capsys):
    file = tmp_path / "build" / "golden.json"
    assert compare(file, {"a": "1", "b": "2"}) == 0
    assert json.loads(file.read_text()) == {"a": "1", "b": "2"}
    assert compare(file, {"b": "2"}) == 0
    assert compare(file, {"a": "1", "b": "3"}) == 1
    assert "differs: b" in capsys.readouterr().out
