"""What is made of a plan later is made without its samples, which may be tens of megabytes."""

import io
import json
import zipfile

import pytest

from service.jobs import json_steps
from service.jobs.job import JobSpec
from service.jobs.json_text import Encoded, encode, encode_in_parts
from service.plans.plan_job import outcome_without_samples
from service.plans.tasks import PLAN

NUM_COPIES = 1000


@pytest.fixture
def vast(app, client, solved):
    """A plan with the motion of another one and NUM_COPIES times its samples, and its text."""
    store = app.state.jobs._store
    job = store.get(solved["id"])
    trajectory = job.result["result"]["trajectory"]
    samples = {
        name: rows * NUM_COPIES if name in {"times", "positions", "velocities"} else rows
        for name, rows in trajectory.items()
    }
    result = encode({**job.result["result"], "trajectory": samples})
    rest = {name: part for name, part in job.result.items() if name != "result"}
    text = encode_in_parts({**rest, "result": Encoded(result)})
    copy, _ = store.insert(JobSpec("plan", PLAN.name, job.payload, prefix="pln", scene=job.scene))
    store.start(copy.id)
    brief = {"timings": rest["timings"], "digest": rest["digest"]}
    store.succeed(copy.id, Encoded(text), Encoded(encode(brief)))
    return copy.id, result


@pytest.fixture
def decoded(monkeypatch):
    """How much JSON was decoded at a time, by whatever thread."""
    found = [0]
    loads = json.loads

    def listen(text, **options):
        found.append(len(text))
        return loads(text, **options)

    monkeypatch.setattr(json, "loads", listen)
    return found


@pytest.mark.parametrize(
    "asked",
    [
        "trajectory?points=5",
        "trajectory?format=csv&points=5",
        "replay.html",
        "plots/position.svg",
        "series?points=3",
        "report.html",
        "bundle.zip",
    ],
)
def test_samples_are_not_decoded(client, vast, decoded, asked):
    plan, result = vast
    answer = client.get(f"/v1/plans/{plan}/{asked}")
    assert answer.status_code == 200, answer.text
    assert sum(decoded) < len(result) / 4


def test_a_bundle_has_the_result_as_it_was_written(client, vast):
    plan, result = vast
    answer = client.get(f"/v1/plans/{plan}/bundle.zip")
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.read("result.json").decode() == f"{result}\n"
        manifest = json.loads(archive.read("bundle.json"))
    assert manifest["digest"] == client.get(f"/v1/plans/{plan}").json()["digest"]


def test_all_but_the_samples_is_there(app, solved):
    store = app.state.jobs._store
    whole = store.get(solved["id"]).result
    brief = store.get(solved["id"], outcome_without_samples).result
    trajectory = whole["result"].pop("trajectory")
    samples = brief["result"].pop("trajectory")
    assert brief == whole
    assert samples.keys() == trajectory.keys()
    for name, rows in trajectory.items():
        is_sampled = name in {"times", "positions", "velocities", "accelerations"}
        assert samples[name] == ([rows[0], rows[-1]] if is_sampled else rows)


@pytest.mark.parametrize("rows", [[], [1.5], [1, 2, 3], [[1.0, -2e-9]], [[1], [2], [3]], [[]]])
def test_ends_are_those_of_the_list(rows):
    found = json_steps.ends_of(json.dumps(rows))
    assert found == ([rows[0], rows[-1]] if rows else [])
