"""Scenes that are edited where they are warm, or read again, or posted whole, are the same."""

import json

import pytest

from service.jobs.worker.context import SilentContext
from service.queries.models.check import CheckRequest
from service.queries.worker import check
from service.scenes import document_text as scene_text
from service.scenes import world_cache as worlds
from service.scenes.models.edits import SceneEdit
from service.scenes.store.document_artifact import artifact_of
from service.scenes.tasks import LoadWork, RequestWork
from service.scenes.worker import load_scene, revise_scene
from tests.service.jobs.hosts import on_host, put

# More than Drake's model takes: an edit changes rows of tables (docs/decisions/0034).
BOXES = [
    {"name": f"b{i}", "shape": {"box": [0.05, 0.05, 0.05]}, "pose": {"position": [0.1 * i, 0.9, 0]}}
    for i in range(50)
]
POSTED = {"robots": [{"name": "arm", "model": "ur5e", "positions": "home"}], "objects": BOXES}
BALL = {"name": "ball", "shape": {"sphere": 0.05}, "pose": {"rpy": [0.3, 0.2, 0.1]}}
EDITS = [
    [{"op": "move", "object": "b7", "pose": {"position": [0.4, 0.1, 0.3], "rpy": [1, 2, 3]}}],
    [{"op": "set_positions", "robot": "arm", "positions": [0.3, -1.2, 1.9, -2.2, -1.5, 0.1]}],
    [{"op": "add", "object": BALL}, {"op": "remove", "object": "b3"}],
    [{"op": "move", "object": "ball", "pose": {"position": [0.3, 0.2, 0.5]}}],
]
WORK = {
    load_scene: LoadWork,
    revise_scene: RequestWork[SceneEdit],
    check: RequestWork[CheckRequest],
}
ASKED = {"group": "arm", "configurations": [[0, -1.2, 1.9, -2.2, -1.5, 0], [1, -1, 1, 0, 0, 0]]}


@pytest.fixture
def task(tmp_path):
    """Call tasks about the scene in a folder."""
    library = {"model_roots": [], "allow_paths": False}

    def call(work, found=None, **more):
        payload = {"library": library, **more}
        if found is not None:
            digest = put(tmp_path, artifact_of(found).content)
            payload["scene"] = {"digest": found.digest, "document": digest}
        return on_host(tmp_path, work, WORK[work].model_validate(payload), SilentContext())

    return call


def forget():
    worlds._idle.clear()
    scene_text._recent.clear()
    scene_text._unchecked.clear()


def test_an_edit_is_the_same_wherever_it_is_made(task):
    forget()
    warm = cold = task(load_scene, text=json.dumps(POSTED), media="json")
    for operations in EDITS:
        request = {"operations": operations}
        warm = task(revise_scene, warm, request=request)
        forget()
        cold = task(revise_scene, cold, request=request)
        assert warm == cold
        told = task(check, warm, request=ASKED)
        forget()
        whole = task(load_scene, text=warm.document.text, media="json")
        assert whole == warm
        assert task(check, whole, request=ASKED) == told
        # Warm again, with the world and the text of the revision that was edited.
        task(revise_scene, whole, request={"operations": [{"op": "remove", "object": "b9"}]})
        task(load_scene, text=warm.document.text, media="json")


def test_where_all_is_warm_nothing_is_read(task, monkeypatch):
    forget()
    found = task(load_scene, text=json.dumps(POSTED), media="json")
    monkeypatch.setattr("service.scenes.worker.read_stored", None)
    for operations in EDITS:
        found = task(revise_scene, found, request={"operations": operations})
    forget()
    with pytest.raises(TypeError):
        task(revise_scene, found, request={"operations": EDITS[0]})
