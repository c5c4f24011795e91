"""The files that docs/how-to/your-own-robot.md shows are what it says of them."""

import re
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.world.world import World
from service.plans.models.pose_goals import PoseGoal
from tests.clocks import no_hurry
from tests.conventions.guide import ROOT, values

PAGE = ROOT / "docs" / "how-to" / "your-own-robot.md"
# A block of code behind a paragraph that names its file.
FILES = dict(
    re.findall(r"`(reacher/[\w.]+)`[^`]*\n\n```\w+\n(.*?)```", PAGE.read_text(), re.DOTALL)
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to start a server in, with nothing of the page yet."""
    (tmp_path / "reacher").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def loaded(folder: Path, *names: str) -> World:
    for name in ("reacher.urdf", "cell.scene.yaml", *names):
        (folder / "reacher" / name).write_text(FILES[f"reacher/{name}"])
    return planning.load_world(planning.read_scene(folder / "reacher" / "cell.scene.yaml"))


def test_the_page_shows_every_file() -> None:
    names = {"reacher.urdf", "robot.yaml", "cell.scene.yaml", "reacher.srdf"}
    assert set(FILES) == {f"reacher/{name}" for name in names}


def test_the_robot_loads_with_its_card_and_nothing_is_odd(folder: Path) -> None:
    world = loaded(folder, "robot.yaml")
    assert planning.scene_summary(world).warnings == planning.scene_summary(world).assumed == ()
    arm = world.group("r")
    assert arm.tool_frames == ("r::tcp", "r::hand")
    assert set(world.configurations(arm)) == {"home", "folded"}
    np.testing.assert_array_equal(world.positions(world.group("r::fingers")), [0.03])
    assert world.limits(arm).acceleration.tolist() == [8, 6, 8, 12, 12]
    judge = world.collision_oracle(arm, world.margins())
    assert all(judge.is_free(q) for q in world.configurations(arm).values())
    with pytest.raises(planning.errors.UnknownName, match="folded"):
        world.configuration(arm, "foldet")


def test_its_goal_needs_the_tolerance_that_the_page_gives(folder: Path) -> None:
    world = loaded(folder, "robot.yaml")
    (body,) = values(PAGE)
    goal = PoseGoal.model_validate(body).to_domain()
    options = planning.IkOptions(max_configurations=3, max_trials=40)
    found = planning.solve_ik(world, "r", goal, deadline=no_hurry(), options=options)
    assert len(found.positions)
    exact = PoseGoal.model_validate({**body, "tolerance": {}}).to_domain()
    few = planning.IkOptions(max_configurations=1, max_trials=4)
    with pytest.raises(planning.errors.GoalUnreachable, match=r"give a `tolerance`"):
        planning.solve_ik(world, "r", exact, deadline=no_hurry(), options=few)


def test_the_srdf_says_the_same_without_a_card(folder: Path) -> None:
    world = loaded(folder, "reacher.srdf")
    assert planning.scene_summary(world).warnings == ()
    arm, fingers = world.group("r"), world.group("r::fingers")
    assert arm.name == world.group("r::arm").name
    assert arm.tool_frames == ("r::hand", "r::tcp")
    np.testing.assert_array_equal(world.positions(arm), [0, 0, 1.2, 0.8, 0])
    np.testing.assert_array_equal(world.configuration(fingers, "open"), [0.03])
    assert world.group("r::all").num_positions == 6
    assert len(planning.scene_summary(world).assumed) == 6


def test_a_xacro_file_is_refused_with_the_command(folder: Path) -> None:
    for name in ("reacher.urdf.xacro", "odd.urdf"):
        file = folder / "reacher" / name
        macro = '<xacro:property name="a" value="1"/>'
        root = f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{macro}</robot>'
        file.write_text(root)
        robot = {"name": "r", "model": str(file)}
        stem = "reacher" if "xacro" in name else "odd-expanded"
        with pytest.raises(planning.errors.WayproofError, match=f"`xacro {name} > {stem}.urdf`"):
            planning.load_world(planning.parse_scene({"name": "s", "robots": [robot]}))


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("bend: {velocity", "bnd: {velocity", "joint 'bnd' does not exist; did you mean 'bend'?"),
        ("turn, lift", "trun, lift", "joint 'trun' does not exist; did you mean 'turn'?"),
        ("[tcp, hand]", "[tpc, hand]", "did you mean 'r::tcp'?"),
        ("- [left_finger", "- [lef_finger", "did you mean 'r::left_finger'?"),
        ("folded: {arm", "folded: {amr", "group 'amr' does not exist; did you mean 'arm'?"),
        ("turn: {velocity", "turn: {velocty", "limits.turn.velocty: "),
    ],
)
def test_what_is_misspelled_in_a_card_is_named(
    folder: Path, right: str, wrong: str, told: str
) -> None:
    (folder / "reacher" / "robot.yaml").write_text(
        FILES["reacher/robot.yaml"].replace(right, wrong, 1)
    )
    with pytest.raises(planning.errors.InputError) as fault:
        loaded(folder)
    assert told in fault.value.detail
    assert "http" not in fault.value.detail
