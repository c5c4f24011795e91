"""known_planners(): the planners that there are, which never change while a server runs."""

from weakref import WeakKeyDictionary

from service.catalog.models import Planner
from service.catalog.tasks import LIST_PLANNERS, NoWork
from service.jobs.service import JobService

_known: WeakKeyDictionary[JobService, list[Planner]] = WeakKeyDictionary()


async def known_planners(jobs: JobService) -> list[Planner]:
    """Return all planners; workers are asked once."""
    if jobs not in _known:
        _known[jobs] = (await jobs.call(LIST_PLANNERS, NoWork())).items
    return _known[jobs]
