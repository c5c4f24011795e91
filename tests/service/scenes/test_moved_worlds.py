"""The world of a scene whose robots have moved is made from one that is there, and is the same."""

import json

import numpy as np
import pytest

from service.errors import SceneNotKept
from service.jobs.worker.context import SilentContext
from service.scenes import world_cache as worlds
from service.scenes.store.document_artifact import artifact_of
from service.scenes.tasks import Library, LoadWork, SceneWork, StoredScene
from service.scenes.worker import load_scene
from tests.service.jobs.hosts import on_host, put

ARM = {"name": "arm", "model": "ur5e", "positions": {"left_finger_joint": 0.01}}
OTHER = {"name": "other", "model": "planar_l", "base": {"position": [2, 0, 0]}}
POSTED = {"robots": [ARM, OTHER]}
LIBRARY = Library(model_roots=[], allow_paths=False)
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
MOVED = {"arm": {f"{name}_joint": 0.1 * i - 0.2 for i, name in enumerate(JOINTS)}}
BOTH = {**MOVED, "other": {"base_joint": [0.1, 0.2, 0.3]}}


@pytest.fixture
def borrowed(tmp_path):
    """Calls with the world of the posted scene and some positions."""
    worlds._idle.clear()
    posted = LoadWork(library=LIBRARY, text=json.dumps(POSTED), media="json")
    loaded = on_host(tmp_path, load_scene, posted, SilentContext())
    document = put(tmp_path, artifact_of(loaded).content)

    def borrow(positions=None, look=lambda world: world, digest=loaded.digest):
        scene = StoredScene(digest=digest, document=document, positions=positions or {})

        def call():
            with worlds.borrow_world(SceneWork(library=LIBRARY, scene=scene)) as world:
                return look(world)

        return on_host(tmp_path, call)

    yield borrow
    worlds._idle.clear()


def state(world):
    return {
        name: np.array(world.state)[world.drake.position_indices(world.group(name))].tolist()
        for name in ("arm", "arm::gripper", "other")
    }


def test_where_a_world_is_warm_nothing_is_read_and_nothing_is_loaded(borrowed, monkeypatch):
    first = borrowed()
    monkeypatch.setattr(worlds, "read_stored", None)
    before = first
    for positions in (MOVED, BOTH, {}, BOTH):
        world = borrowed(positions)
        assert world.shares_engine_with(before)
        assert len(worlds._idle) == 1
        before = world
    assert borrowed(BOTH) is before


def test_robots_are_where_the_state_has_them_warm_or_not(borrowed):
    described = borrowed(look=state)
    for positions in (MOVED, BOTH, {}, MOVED):
        warm = borrowed(positions, look=state)
        worlds._idle.clear()
        assert borrowed(positions, look=state) == warm
        arm = list(MOVED["arm"].values()) if positions else described["arm"]
        assert warm["arm"] == pytest.approx(arm, abs=1e-15)
        assert warm["arm::gripper"] == described["arm::gripper"] == [0.01]
        other = BOTH["other"]["base_joint"] if positions is BOTH else described["other"]
        assert warm["other"] == other


def test_a_scene_that_is_another_one_by_now_is_refused_wherever_its_robots_are(borrowed):
    for positions in ({}, MOVED):
        worlds._idle.clear()
        with pytest.raises(SceneNotKept):
            borrowed(positions, digest="0" * 64)


BOX = {"name": "box", "shape": {"box": [0.1, 0.1, 0.1]}, "pose": {"position": [0.6, 0, 0.1]}}


@pytest.fixture
def both_borrowed(tmp_path):
    """Borrows worlds of the posted scene, and of another one with the same robots and a box."""
    worlds._idle.clear()
    works = []
    for objects in ([], [BOX]):
        posted = LoadWork(
            library=LIBRARY, text=json.dumps({**POSTED, "objects": objects}), media="json"
        )
        loaded = on_host(tmp_path, load_scene, posted, SilentContext())
        document = put(tmp_path, artifact_of(loaded).content)
        scene = StoredScene(digest=loaded.digest, document=document, positions={})
        works.append(SceneWork(library=LIBRARY, scene=scene))
    yield lambda look: on_host(tmp_path, look, *(worlds.borrow_world(work) for work in works))
    worlds._idle.clear()


def test_scenes_with_the_same_robots_share_an_engine_and_both_stay_warm(both_borrowed, monkeypatch):
    assert len(worlds._idle) == 2
    monkeypatch.setattr(worlds, "load_world", None)

    def look(bare, boxed):
        with bare as world:
            first = world
        with boxed as world:
            assert world.shares_engine_with(first)
            assert "box" in world.drake.all_bodies
        assert "box" not in first.drake.all_bodies

    both_borrowed(look)
    assert len(worlds._idle) == 2


def test_worlds_that_share_an_engine_are_not_lent_at_a_time(both_borrowed):
    def look(bare, boxed):
        with bare as first, boxed as second:
            assert not first.shares_engine_with(second)
            assert state(first) == state(second)

    both_borrowed(look)
    assert len(worlds._idle) == 3
    assert not worlds._lent
