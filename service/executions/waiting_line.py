"""WaitingLine: executions that wait for their robots begin, in their order, once these are free.

Each is proven then, from where the robots are then; what cannot be carried out any more is planned
anew if it asks for that, and keeps its place meanwhile, or ends with the reason. The record is the
table: a server that leads takes the line up where the last one left it.
"""

import asyncio
import logging
from dataclasses import replace

from planning.errors import NotCertified, WayproofError
from service.errors import StartMismatch, status_of
from service.executions.drivers.controllers import check_driven
from service.executions.motions.requested_motion import asked_motion
from service.executions.proofs.admission import Place, proven_work
from service.executions.replanning.plans_in_line import PlansInLine
from service.executions.requests import ExecutionRequest
from service.executions.tasks import EXECUTE, WaitingExecution
from service.jobs.errors import Overtaken
from service.jobs.job import IdempotencyKey, JobSpec, JobSummary
from service.jobs.store.entries import Entries
from service.jobs.store.sql.database import is_of_database
from service.plans.submit import PlanTerms
from service.scenes.job_spec import spec_of
from service.scenes.store.scene_store import SceneStore

# Between two looks at the line, while something waits and while nothing does [s].
_LOOK, _LOOK_WHEN_EMPTY = 0.1, 0.5
# Of a server that is busy or away: asked again later, nothing is refused.
_TRANSIENT = {408, 429, 503}
_log = logging.getLogger(__name__)


class WaitingLine:
    """Has what waits begin; of the server that leads."""

    def __init__(self, scenes: SceneStore, terms: PlanTerms) -> None:
        """Read the records of scenes and of executions, and plan by `terms`."""
        self._scenes = scenes
        self._jobs = terms.jobs
        self._plans = PlansInLine(terms, scenes)

    async def run(self) -> None:
        """Look after the line until canceled."""
        while True:
            waits = True
            try:
                waits = await self._advance()
            except Exception as fault:  # noqa: BLE001  (the line is looked after whatever happens)
                if not is_of_database(fault):
                    _log.exception("executions that wait for their robots were not looked after")
            await asyncio.sleep(_LOOK if waits else _LOOK_WHEN_EMPTY)

    async def _advance(self) -> bool:
        """Have begin what can; return whether something waits."""
        if self._jobs.is_stopping:
            return False
        waiting = await self._jobs.waiting.jobs()
        self._plans.keep([job.id for job in waiting])
        for job in waiting:
            if self._plans.is_planning(job.id):
                continue
            entries = await self._jobs.entries(EXECUTE.queue, job.scene or "")
            if entries.is_free_for(job.id):
                await self._begin(job, entries)
        return bool(waiting)

    async def _begin(self, job: JobSummary, entries: Entries) -> None:
        """Have an execution begin whose robots are free, or end it with the reason why not."""
        try:
            spec, revision = await self._proven(job, entries)
            with self._scenes.latest.changing(job.scene or ""):
                await self._jobs.waiting.release(job.id, spec)
            edited = await self._scenes.fresh(job.scene or "")
            if edited.revision != revision:  # it has seen no execution: this one sees it
                await self._scenes.verdicts(edited)
        except Overtaken:
            return
        except WayproofError as fault:
            if status_of(fault) in _TRANSIENT:
                _log.warning("%s is proven later: %s", job.id, fault)
                self._plans.forget(job.id)
                return
            await self._jobs.waiting.refuse(job.id, fault)
            with self._scenes.latest.changing(job.scene or ""):
                pass  # who watches the scene reads it again

    async def _proven(self, job: JobSummary, entries: Entries) -> tuple[JobSpec, int]:
        """Return what is carried out, and the revision that it is proven in, from where robots are.

        Raises as `proven_work`; `Overtaken` as well while the motion is planned anew.
        """
        scenes, jobs = self._scenes, self._jobs
        whole = await jobs.job(EXECUTE.queue, job.id)  # lists have no motion of one's own
        work = WaitingExecution.model_validate(whole.payload)
        own = None if work.own is None else work.own.model_dump(exclude_unset=True)
        request = ExecutionRequest.model_validate({
            **work.request.model_dump(exclude_unset=True),
            "trajectory": own,
        })
        asked = await asked_motion(request, jobs)
        record = await scenes.fresh(work.scene_id)
        group = asked.group_in(record)
        check_driven(request.driver, group)
        place = Place(record, group, entries, work.address)
        asked, replanned = self._plans.made(job.id) or (asked, None)
        try:
            proven = await proven_work(asked, work.request, place, scenes=scenes, jobs=jobs)
        except (NotCertified, StartMismatch) as fault:
            if request.on_not_certified == "refuse" or replanned is not None:
                raise
            self._plans.begin(job.id, asked, fault)
            raise Overtaken from None
        proven = proven.model_copy(update={"replanned": replanned})
        spec = spec_of(EXECUTE, proven, record, IdempotencyKey(None, {}))
        return replace(spec, follows=entries.number, robots=proven.held_robots), record.revision
