"""The bundled Panda laid out as the benchmark's data are, and a problem of one box."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

import planning
from planning.world.models.robot_card import read_robot_card

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
START = [-0.7, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
GOAL = [0.7, *START[1:]]


def problem_entry(name: str, index: int, position: list[float], dims: list[float]) -> dict:
    box = {"name": "box", "type": "box", "dims": dims, "pos": position, "quat": [1, 0, 0, 0]}
    head = {"robot": "panda", "set": name, "index": index, "joints": JOINTS}
    return {**head, "start": START, "goal": GOAL, "objects": [box]}


@pytest.fixture(scope="session")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the bundled Panda and an SRDF of its allowed collisions."""
    source = planning.bundled_folder("models") / "panda"
    root = tmp_path_factory.mktemp("models")
    folder = root / "panda"
    folder.mkdir()
    (folder / "panda.urdf").symlink_to(source / "panda.urdf")
    semantic = ET.Element("robot", name="panda")
    for a, b in read_robot_card(source / "robot.yaml").allowed_collisions:
        ET.SubElement(semantic, "disable_collisions", link1=a, link2=b)
    ET.ElementTree(semantic).write(folder / "panda.srdf")
    return root


@pytest.fixture
def problem_file(tmp_path: Path) -> Path:
    """Return a file with two problems: a box beside the way, and one where the arm starts."""
    file = tmp_path / "problems.json"
    beside = problem_entry("beside", 1, [0.45, 0.0, 0.1], [0.1, 0.1, 0.2])
    inside = problem_entry("inside", 1, [0.0, 0.0, 0.4], [0.3, 0.3, 0.3])
    file.write_text(json.dumps([beside, inside]))
    return file
