"""By when the process of a plan has to end: it is told once the scene is loaded."""

import json

import pytest

from service.plans.admission import SLACK
from service.tasks.plan import plan_motion
from service.tasks.scenes import load_scene
from tests.service.conftest import BLOCK_SCENE

ALLOWED = 60.0


class Channel:
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
    loaded = load_scene(posted, Channel())
    file = tmp_path / "scene.json"
    kept = {"document": loaded["document"], "files": loaded["summary"]["files"]}
    file.write_text(json.dumps(kept))
    request = {"scene": "s", "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": ALLOWED}
    return {
        "scene": {"digest": loaded["digest"], "document": str(file)},
        "library": library,
        "request": request,
    }


def test_the_allowed_time_begins_once_the_scene_is_loaded(payload):
    channel = Channel()
    assert plan_motion(payload, channel)["digest"]
    terms = [note for note in channel.notes if isinstance(note, float)]
    assert len(terms) == 2
    assert ALLOWED < terms[0] < ALLOWED + SLACK
    assert channel.notes.index("load") < channel.notes.index(terms[0])
    assert channel.notes.index(terms[0]) < channel.notes.index("goals")
    assert terms[1] <= SLACK
    assert channel.notes[-1] == terms[1]
