"""By when the process of a plan has to end: it is told once the scene is loaded."""

import json

import pytest

from planning.errors import DeadlineExceeded
from service.plans.submit import SLACK
from service.plans.worker import plan_motion
from service.scenes.worker import load_scene
from tests.service.conftest import BLOCK_SCENE

ALLOWED = 60.0


class TaskContext:
    """Notes what a task says, in order."""

    def __init__(self):
        self.notes = []

    def emit(self, event_type, data):
        if event_type == "stage":
            self.notes.append(data["stage"])

    def allow(self, seconds):
        self.notes.append(seconds)

    def is_canceled(self):
        return False


@pytest.fixture
def payload(tmp_path):
    library = {"model_roots": [], "allow_paths": False, "copies": str(tmp_path / "files")}
    posted = {"library": library, "text": json.dumps(BLOCK_SCENE), "media": "json"}
    loaded = load_scene(posted, TaskContext())
    file = tmp_path / "scene.json"
    kept = {"document": json.loads(loaded["document"].text), "files": loaded["summary"]["files"]}
    file.write_text(json.dumps(kept))
    request = {"scene": "s", "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": ALLOWED}
    return {
        "scene": {"digest": loaded["digest"], "document": str(file)},
        "library": library,
        "request": request,
    }


def test_the_allowed_time_begins_once_the_scene_is_loaded(payload):
    channel = TaskContext()
    assert plan_motion(payload, channel)["digest"]
    terms = [note for note in channel.notes if isinstance(note, float)]
    assert len(terms) == 2
    assert ALLOWED < terms[0] < ALLOWED + SLACK
    assert channel.notes.index("load") < channel.notes.index(terms[0])
    assert channel.notes.index(terms[0]) < channel.notes.index("goals")
    assert terms[1] <= SLACK
    assert channel.notes[-1] == terms[1]


def test_a_plan_that_is_late_says_where_it_was_and_how_long_loading_took(payload):
    payload["request"]["search"]["allowed_planning_time"] = 1e-6
    channel = TaskContext()
    with pytest.raises(DeadlineExceeded) as caught:
        plan_motion(payload, channel)
    stages = [note for note in channel.notes if isinstance(note, str)]
    assert caught.value.stage == stages[-1]
    assert {"load", caught.value.stage, "total"} <= set(caught.value.timings)


@pytest.mark.parametrize("is_late", [False, True])
def test_samples_that_there_is_no_time_to_prove_are_delivered_as_such(
    payload, monkeypatch, is_late
):
    if is_late:
        monkeypatch.setattr("service.plans.worker.PROVING", 0.0)
    done = plan_motion(payload, TaskContext())
    assert done["result"]["certificate"]["proven"]
    assert done["result"]["cut_short"] == (["samples"] if is_late else [])
    proofs = done["result"]["trajectory"]["interpolations"]
    assert not (is_late and any(proof["proven"] for proof in proofs))
    assert {"load", "samples", "total"} <= set(done["timings"])
