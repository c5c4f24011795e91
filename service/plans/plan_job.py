"""A plan with what it keeps, but for the samples of its motion, which may be tens of megabytes.

All that is made of a plan later is made from its polynomial. Samples are not even decoded: as
Python's numbers they are ten times as large, and are freed while nothing else runs.
"""

from typing import Any

from service.jobs.job import Job
from service.jobs.json_steps import decode, ends_of, members_of
from service.jobs.service import JobService

_SAMPLED = {"times", "positions", "velocities", "accelerations"}


async def read_plan(jobs: JobService, identifier: str) -> Job:
    """Return a plan whose result has the first and the last of its samples.

    Raises:
        UnknownResource: There is no such plan.
    """
    return await jobs.job("plan", identifier, outcome_without_samples)


def outcome_without_samples(text: str) -> dict[str, Any]:
    """Return a `PlanOutcome` from its text, with the first and the last of its samples."""
    parts = dict(members_of(text))
    outcome = {name: decode(part) for name, part in parts.items() if name != "result"}
    result = dict(members_of(parts["result"]))
    trajectory = dict(members_of(result.pop("trajectory")))
    samples = {
        name: ends_of(part) if name in _SAMPLED else decode(part)
        for name, part in trajectory.items()
    }
    rest = {name: decode(part) for name, part in result.items()}
    return {**outcome, "result": {**rest, "trajectory": samples}}
