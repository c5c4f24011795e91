"""Limits in robot.yaml limit something that the joint has, or are refused: none is dropped."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import planning
from planning.errors import ModelInvalid, UnknownName
from planning.world.world import World
from tests.pipeline.test_cars import CARD, TRUCK


def load(folder: Path, limits: dict[str, Any]) -> World:
    card = yaml.safe_load(CARD)
    for name, stated in limits.items():
        card["limits"].setdefault(name, {}).update(stated)
    model = folder / "truck"
    model.mkdir()
    (model / "truck.urdf").write_text(TRUCK)
    (model / "robot.yaml").write_text(yaml.safe_dump(card))
    text = "robots:\n  - {name: truck, model: truck, positions: [0, 0, 0, 0]}\n"
    return planning.load_world(planning.parse_scene(text), planning.ModelLibrary([folder]))


def test_limits_that_joints_have(tmp_path: Path) -> None:
    world = load(
        tmp_path,
        {
            "drive": {
                "position": {"x": [-1.5, 1.5], "yaw": [-1.0, 1.0]},
                "effort": {"force": 9.0, "torque": 2.0},
            },
            "shoulder": {"velocity": 0.5, "effort": 3.0},
        },
    )
    limits = world.limits(world.group("truck"))
    assert limits.lower.tolist() == [-1.5, -np.inf, -1.0, -2.0]
    assert limits.effort.tolist() == [9.0, 2.0, 3.0]


def test_a_coordinate_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UnknownName) as refusal:
        load(tmp_path, {"drive": {"position": {"theta": [-1.0, 1.0]}}})
    assert refusal.value.evidence["name"] == "theta"
    assert refusal.value.evidence["known"] == ["x", "y", "yaw"]


@pytest.mark.parametrize(
    ("joint", "stated", "named"),
    [
        ("drive", {"velocity": 0.1}, "velocity"),
        ("drive", {"jerk": 1.0}, "jerk"),
        ("drive", {"effort": 1.0}, "effort"),
        ("shoulder", {"position": {"shoulder": [-1.0, 1.0]}}, "position"),
        ("shoulder", {"linear": {"velocity": 1, "acceleration": 1, "jerk": 1}}, "linear"),
        ("shoulder", {"effort": {"force": 1.0, "torque": 1.0}}, "effort"),
    ],
)
def test_a_limit_that_joints_of_the_type_do_not_have_is_refused(
    tmp_path: Path, joint: str, stated: dict[str, Any], named: str
) -> None:
    with pytest.raises(ModelInvalid, match=named) as refusal:
        load(tmp_path, {joint: stated})
    assert refusal.value.evidence["joint"] == joint
