"""Names of the files in a bundle, and what its manifest says."""

from typing import Literal

from service.jobs.task import TaskModel

MANIFEST, WORK, README, TEST = "bundle.json", "work.json", "README.md", "test_replay.py"
REQUEST, RESULT, FAILURE = "request.json", "result.json", "failure.json"
SCENE = "scene.json"
# Folders: of the files of robots and meshes by robot or object, and of all else that workers read.
FILES, ARTIFACTS = "files", "artifacts"

# Raised with every change that an older version would misread.
FORMAT = 1


class FailureBrief(TaskModel):
    """How a plan failed.

    Attributes:
        code: Of the failure.
        stage: In which stage; empty if in none.
        detail: In words.
    """

    code: str
    stage: str
    detail: str


class Manifest(TaskModel):
    """What a bundle is of.

    Attributes:
        format: Of the bundle.
        plan: Id of the plan.
        task: That made it.
        state: How it ended.
        scene_digest: Of the scene's content, the bytes of all files included.
        digest: sha256 over the delivered numbers; None of a plan that failed.
        failure: Of a plan that failed.
        cut_short: Stages that the clock ended early: another run may give other bytes.
        versions: Of everything that the numbers depend on.
        processor: Of the machine that packed it, most often the one that planned.
    """

    format: Literal[1] = FORMAT
    plan: str
    task: Literal["plan", "reverse"]
    state: Literal["succeeded", "failed"]
    scene_digest: str
    digest: str | None
    failure: FailureBrief | None
    cut_short: list[str]
    versions: dict[str, str]
    processor: str


README_TEXT = """\
# Plan {plan}

`{plan}` {ended}, by the versions in `bundle.json`. This folder has all that it was made from.

| File | Has |
|---|---|
| `request.json` | the request, as `POST /v1/plans` takes it |
| `{outcome}` | what came of it |
| `scene.json` | the scene |
| `files/` | files of its robots and meshes; equal ones once |
| `artifacts/` | what else planning reads, by sha256 |
| `work.json` | what the worker was given |
| `bundle.json` | digests and versions |

Where Wayproof is installed, this plans again and compares what comes out:

    wayproof replay bundle.zip
    python -m pytest test_replay.py

Robots and meshes are read by parsers in C++: replay bundles of origins that you trust.
"""

TEST_TEXT = '''\
"""Plans {plan} again from this folder, and compares what comes out."""

from pathlib import Path

from service.plans.bundle.replay import replay_bundle


def test_the_same_bytes_come_out() -> None:
    replay = replay_bundle(Path(__file__).parent)
    assert replay.is_same, replay.text
'''
