"""By when the process of a plan has to end: it is told once the scene is loaded."""

import json

import pytest

from planning.errors import DeadlineExceeded
from service.jobs.worker.protocol import MessageKind
from service.jobs.worker.run_task import run_task
from service.plans.models.request import PlanRequest
from service.plans.submit import SLACK
from service.plans.tasks import PLAN, PlanWork
from service.plans.worker import plan_motion
from service.scenes.store.document_artifact import artifact_of
from service.scenes.tasks import LoadWork
from service.scenes.worker import load_scene
from tests.service.conftest import BLOCK_SCENE
from tests.service.jobs.hosts import on_host, put

ALLOWED = 60.0


class TaskContext:
    """Notes what a task says, in order."""

    def __init__(self):
        self.notes = []
        self.progress = []

    def emit(self, event_type, data):
        if "progress" in data:
            self.progress.append(data["progress"])
        if event_type == "stage":
            self.notes.append(data["stage"])

    def allow(self, seconds, grace=0.0):
        self.notes.append(seconds + grace)

    def is_canceled(self):
        return False


@pytest.fixture
def payload(tmp_path):
    library = {"model_roots": [], "allow_paths": False}
    posted = {"library": library, "text": json.dumps(BLOCK_SCENE), "media": "json"}
    loaded = on_host(tmp_path, load_scene, LoadWork.model_validate(posted), TaskContext())
    digest = put(tmp_path, artifact_of(loaded).content)
    request = {"scene": "s", "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": ALLOWED}
    return {
        "scene": {"digest": loaded.digest, "document": digest},
        "library": library,
        "request": request,
        "revision": 1,
    }


def test_the_allowed_time_begins_once_the_scene_is_loaded(payload, tmp_path):
    channel = TaskContext()
    assert on_host(tmp_path, plan_motion, PlanWork.model_validate(payload), channel).digest
    terms = [note for note in channel.notes if isinstance(note, float)]
    assert len(terms) == 2
    assert ALLOWED < terms[0] < ALLOWED + SLACK
    assert channel.notes.index("load") < channel.notes.index(terms[0])
    assert channel.notes.index(terms[0]) < channel.notes.index("goals")
    assert terms[1] <= SLACK
    assert channel.notes[-1] == terms[1]


def test_a_plan_that_hangs_is_soon_ended_and_told_what_was_asked_for(payload, tmp_path):
    class Context(TaskContext):
        def allow(self, seconds, grace=0.0):
            self.notes.append((seconds, grace))

    channel = Context()
    on_host(tmp_path, plan_motion, PlanWork.model_validate(payload), channel)
    (allowed, grace), _ = [note for note in channel.notes if isinstance(note, tuple)]
    assert allowed == ALLOWED
    assert 0.0 < grace <= 1.0


def test_a_plan_that_is_late_says_where_it_was_and_how_long_loading_took(payload, tmp_path):
    payload["request"]["search"]["allowed_planning_time"] = 1e-6
    channel = TaskContext()
    with pytest.raises(DeadlineExceeded) as caught:
        on_host(tmp_path, plan_motion, PlanWork.model_validate(payload), channel)
    stages = [note for note in channel.notes if isinstance(note, str)]
    assert caught.value.stage == stages[-1]
    assert {"load", caught.value.stage, "total"} <= set(caught.value.timings)
    # All of its time is over: it came to the end of the stage, and not beyond.
    assert channel.progress == sorted(channel.progress)
    end = {"goals": 0.1, "search": 0.5}[caught.value.stage]
    assert 0.95 * end < channel.progress[-1] < end


@pytest.mark.parametrize("is_late", [False, True])
def test_samples_that_there_is_no_time_to_prove_are_delivered_as_such(
    payload, tmp_path, monkeypatch, is_late
):
    if is_late:
        monkeypatch.setattr("service.plans.worker.PROVING", 0.0)
    work = PlanWork.model_validate(payload)
    done = on_host(tmp_path, plan_motion, work, TaskContext()).model_dump()
    assert done["result"]["certificate"]["proven"]
    assert done["result"]["cut_short"] == (["samples"] if is_late else [])
    proofs = done["result"]["trajectory"]["interpolations"]
    assert not (is_late and any(proof["proven"] for proof in proofs))
    assert {"load", "samples", "total"} <= set(done["timings"])


def test_jobs_that_older_servers_queued_are_run(payload, tmp_path):
    stored = json.dumps({**payload, "roadmaps": "", "cores": None})
    end = on_host(tmp_path, run_task, PLAN.name, stored, TaskContext())
    assert end.kind is MessageKind.RESULT, end.text
    outcome = json.loads(end.text)
    assert outcome["result"]["certificate"]["proven"]
    outline = {"timings", "digest", "cut_short"}
    assert set(json.loads(end.summary)) == outline
    assert set(outcome) == {*outline, "result", "polynomial", "graph"}


def test_payloads_are_stored_without_what_they_lack(payload):
    stored = PlanWork.model_validate(payload).model_dump(mode="json")
    assert set(stored) == {*payload, "cores"}
    assert stored["request"] == PlanRequest.model_validate(payload["request"]).model_dump()
    assert PlanWork.model_validate(stored) == PlanWork.model_validate(payload)
    graced = PlanWork.model_validate({**payload, "cancel_grace": 0.9})
    assert graced.model_dump(mode="json")["cancel_grace"] == 0.9
