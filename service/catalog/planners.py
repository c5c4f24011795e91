"""known_planners(): the planners that there are, which never change while a server runs."""

from service.catalog.models import Planner
from service.catalog.tasks import LIST_PLANNERS, NoWork
from service.jobs.service import JobService


async def known_planners(jobs: JobService) -> list[Planner]:
    """Return all planners; workers are asked once."""
    return (await jobs.call_once(LIST_PLANNERS, NoWork())).items
