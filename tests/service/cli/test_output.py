"""Summaries have everything a person asks for."""

import json

import pytest

from service.cli import output
from wayproof_client import models
from wayproof_client.connection import adapter
from wayproof_client.models import Joint, Plan, Scene


@pytest.fixture
def wide(monkeypatch):
    monkeypatch.setattr(output.console, "width", 200)


@pytest.mark.usefixtures("wide")
def test_the_summary_has_stages_funnel_length_duration_and_proof(solved, capsys):
    job = Plan.model_validate(solved)
    assert job.result is not None
    output.show_plans({"to ready": job})
    told = capsys.readouterr().out
    for wanted in ("goals, ms", "search, ms", "IK: tried", "path length", "duration", "proven"):
        assert wanted in told
    assert f"{job.result.certificate.min_clearance:.4f}" in told
    assert " and ".join(job.result.certificate.pair) in told


@pytest.mark.usefixtures("wide")
def test_what_is_not_in_the_total_stands_below_it(solved, capsys):
    output.show_plans({"to ready": Plan.model_validate(solved)})
    rows = [line for line in capsys.readouterr().out.splitlines() if ", ms" in line]
    total = next(i for i, row in enumerate(rows) if "total, ms" in row)
    assert [("loading the scene" in row, "not in the total" in row) for row in rows] == [
        (i > total, i > total) for i in range(len(rows))
    ]


@pytest.mark.usefixtures("wide")
@pytest.mark.parametrize(
    ("types", "unit"),
    [
        (["revolute", "continuous"], "rad"),
        (["prismatic", "prismatic"], "m"),
        (["prismatic", "revolute"], "rad or m"),
        (["planar"], "rad or m"),
    ],
)
def test_lengths_have_the_unit_of_the_joints(client, scene, solved, capsys, types, unit):
    group = Scene.model_validate(client.get(f"/v1/scenes/{scene}").json()).groups[0]
    joints = [Joint.model_construct(name="r::j", type=type_) for type_ in types]
    measured = output.unit_of(group.model_copy(update={"joints": joints}))
    output.show_plans({"to ready": Plan.model_validate(solved)}, measured)
    assert f"path length, {unit} " in capsys.readouterr().out


@pytest.mark.usefixtures("wide")
def test_following_shows_how_far_a_job_is(capsys):
    at = "2026-01-01T00:00:00Z"
    said = [
        ("stage", {"stage": "search", "progress": 0.2, "detail": "", "timings": {}}),
        ("finished", {"state": "succeeded", "failure": None}),
    ]
    output.follow(
        "plan",
        (
            adapter(models.JobEvent).validate_python({
                "id": str(i),
                "event": kind,
                "data": json.dumps({"at": at, **data}),
            })
            for i, (kind, data) in enumerate(said)
        ),
    )
    shown = capsys.readouterr().err
    assert "100 %" in shown
    assert "succeeded" in shown
