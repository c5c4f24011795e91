"""What `--to`, `--from` and `--group` mean."""

import pytest
import typer

from service.cli.goal import goal_of, group_of, start_of
from service.scenes.models.scene import Scene


@pytest.fixture
def posted(client, scene):
    return Scene.model_validate(client.get(f"/v1/scenes/{scene}").json())


def test_a_frame_is_a_pose_goal(posted):
    goal = goal_of(posted, group_of(posted, None), "above")
    assert goal == {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": "above"}]}


def test_a_configuration_is_itself(posted):
    group = group_of(posted, "arm::arm")
    assert goal_of(posted, group, "ready") == {"type": "configuration", "name": "ready"}
    assert start_of(group, "ready") == group.configurations["ready"]
    assert start_of(group, None) is None


@pytest.mark.parametrize(
    ("attempt", "known"),
    [
        (lambda scene: goal_of(scene, group_of(scene, "arm"), "abov"), ["above", "ready"]),
        (lambda scene: start_of(group_of(scene, "arm"), "abov"), ["ready"]),
        (lambda scene: group_of(scene, "abov"), ["arm"]),
    ],
)
def test_unknown_names_end_with_those_that_exist(posted, capsys, attempt, known):
    with pytest.raises(typer.Exit) as ended:
        attempt(posted)
    assert ended.value.exit_code == 2
    told = capsys.readouterr().err
    assert "abov" in told
    assert [name for name in known if name not in told] == []


@pytest.mark.parametrize(
    ("attempt", "nearest"),
    [
        (lambda scene: goal_of(scene, group_of(scene, "arm"), "abov"), "above"),
        (lambda scene: start_of(group_of(scene, "arm"), "redy"), "ready"),
        (lambda scene: group_of(scene, "amr"), "arm"),
    ],
)
def test_a_misspelt_name_is_answered_with_the_nearest(posted, capsys, attempt, nearest):
    with pytest.raises(typer.Exit):
        attempt(posted)
    assert f"did you mean '{nearest}'?" in " ".join(capsys.readouterr().err.split())
