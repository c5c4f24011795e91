"""What a poll of a plan shows while it runs."""

from dataclasses import replace

import pytest

from service.jobs.job import JobSpec
from service.jobs.states import JobState
from service.jobs.store.drafts import draft
from service.plans.resource import plan_resource
from service.plans.tasks import PLAN

REQUEST = {"scene": "s", "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
FOUND = {"detail": "a path", "length": 2.5, "seconds": 0.25, "waypoints": [[0.0], [2.5]]}


class Jobs:
    """Knows one event."""

    def __init__(self, best):
        self.best = best
        self.asked = []

    async def latest_event(self, job, event_type):
        self.asked.append((job.id, event_type))
        return self.best

    def unrecorded(self, _):
        return []

    def with_cancel(self, job):
        return job


def job_in(state):
    payload = {"request": {**REQUEST, "seed": 1}, "revision": 1}
    job = draft(JobSpec("plan", PLAN.name, payload)).job
    return replace(job, state=state, stage="search", progress=0.3)


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("best", "shown"),
    [
        (None, None),
        (FOUND, {"length": 2.5, "seconds": 0.25, "waypoints": [[0.0], [2.5]]}),
        ({"length": 2.5}, {"length": 2.5, "seconds": None, "waypoints": None}),
        ({"truncated": True}, None),
    ],
)
async def test_a_running_plan_shows_its_progress_and_its_best_path(best, shown):
    plan = (await plan_resource(Jobs(best), job_in(JobState.RUNNING))).model_dump()
    assert (plan["stage"], plan["progress"], plan["best"]) == ("search", 0.3, shown)


@pytest.mark.anyio
@pytest.mark.parametrize("state", sorted(set(JobState) - {JobState.RUNNING}))
async def test_no_events_are_read_for_other_plans(state):
    jobs = Jobs(FOUND)
    assert (await plan_resource(jobs, job_in(state))).best is None
    assert jobs.asked == []
