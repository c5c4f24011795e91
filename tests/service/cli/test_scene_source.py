"""Scenes are found by bundled name or by path."""

import pytest

from service.cli.scene_source import NoSuchScene, bundled_scenes, read_scene_text


def test_bundled_scenes_are_found_by_name():
    assert {"ur5e_pickup", "panda_shelf", "maze_2d", "window_3d"} <= set(bundled_scenes())
    text, media = read_scene_text("ur5e_pickup")
    assert b"ur5e" in text
    assert media == "application/yaml"


def test_files_are_read_as_their_ending_says(tmp_path):
    for name, media in (("a.json", "application/json"), ("a.yml", "application/yaml")):
        (tmp_path / name).write_text("x")
        assert read_scene_text(str(tmp_path / name)) == (b"x", media)


def test_what_is_neither_is_told_with_what_there_is(tmp_path):
    with pytest.raises(NoSuchScene, match="ur5e_pickup"):
        read_scene_text(str(tmp_path / "none.yaml"))


def test_a_misspelt_scene_is_answered_with_the_nearest():
    with pytest.raises(NoSuchScene, match=r"did you mean 'ur5e_pickup'\?"):
        read_scene_text("ur5_pickup")
