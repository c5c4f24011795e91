"""Summaries have everything a person asks for."""

import pytest

from service.cli import screen
from service.client.events import Event
from service.schemas.job import Job


@pytest.fixture
def wide(monkeypatch):
    monkeypatch.setattr(screen.console, "width", 200)


@pytest.mark.usefixtures("wide")
def test_the_summary_has_stages_funnel_length_duration_and_proof(solved, capsys):
    job = Job.model_validate(solved)
    assert job.result is not None
    screen.show_plans({"to ready": job})
    told = capsys.readouterr().out
    for wanted in ("goals, ms", "search, ms", "IK: tried", "path length", "duration", "proven"):
        assert wanted in told
    assert f"{job.result.certificate.min_clearance:.4f}" in told
    assert " and ".join(job.result.certificate.pair) in told


@pytest.mark.usefixtures("wide")
def test_following_returns_the_last_event(capsys):
    events = [
        Event("1", "stage", {"stage": "search", "progress": 0.2}),
        Event("2", "finished", {"state": "succeeded", "progress": 1.0}),
    ]
    assert screen.follow("plan", events) == events[-1].data
    assert "100 %" in capsys.readouterr().out
