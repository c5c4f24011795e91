"""What is known of a scene stays true until something is done to it, and only then is kept."""

import asyncio
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import pytest

from service.executions.settlement import settled

CREATED = datetime(2026, 1, 1, tzinfo=UTC)
LATER, BEFORE = CREATED + timedelta(seconds=1), CREATED - timedelta(seconds=1)
RECORD = SimpleNamespace(id="scn", created_at=CREATED)


class SceneJobs:
    """Knows one execution at most."""

    def __init__(self, *executions):
        self.executions = executions

    async def newest(self, queue, *, scene):
        assert (queue, scene) == ("execution", RECORD.id)
        for job in self.executions:
            yield job

    async def latest_event(self, job, event_type):
        return None


def execution(finished_at):
    return SimpleNamespace(finished_at=finished_at, result=None)


@pytest.mark.parametrize(
    ("jobs", "is_at_rest"),
    [
        (SceneJobs(), True),
        (SceneJobs(execution(BEFORE)), True),
        (SceneJobs(execution(LATER)), True),  # it never moved
        (SceneJobs(execution(None)), False),
        (SceneJobs(execution(None), execution(BEFORE)), False),
    ],
)
def test_a_revision_is_the_latest_for_good_once_nothing_moves(jobs, is_at_rest):
    assert asyncio.run(settled(RECORD, None, jobs)) == (RECORD, is_at_rest)
