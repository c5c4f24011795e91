"""Desk: where endpoints hand in jobs and questions; one dispatcher stands behind it."""

import asyncio
from collections.abc import AsyncIterator, Callable
from functools import partial
from pathlib import Path
from typing import Any

from anyio import to_thread
from pydantic import BaseModel

from service.api.client_disconnect import note_question, unless_client_leaves
from service.catalog.models import Planner
from service.catalog.tasks import LIST_PLANNERS, NoWork
from service.errors import NotReady, UnknownResource
from service.job_spec import PREFIXES
from service.jobs.calls import Question
from service.jobs.dispatcher import Dispatcher
from service.jobs.errors import UnknownJob
from service.jobs.json_text import Encoded
from service.jobs.records import Job, JobBrief, JobPage, JobSpec, JobText, LoggedEvent
from service.jobs.states import JobState
from service.jobs.store import JobStore
from service.jobs.tasks import Task
from service.scenes.records import SceneRecord
from service.scenes.store import SceneStore
from service.scenes.tasks import LibraryWork, LoadedScene, SceneWork
from service.settings import Settings

LANES = ("plan", "query", "execution", "regions")
_CHUNK = 20


class Desk:
    """Takes jobs and questions from coroutines of one event loop."""

    def __init__(
        self, settings: Settings, store: JobStore, dispatcher: Dispatcher, scenes: SceneStore
    ) -> None:
        """Put the parts together; the dispatcher runs already."""
        self._settings = settings
        self._store = store
        self._dispatcher = dispatcher
        self._scenes = scenes
        self._planners: list[Planner] = []
        self.admitting_motion = asyncio.Lock()
        # Where links lead is asked of the disk once, not for each task.
        self._folder = settings.data_dir.resolve()
        self._model_roots = [str(root.resolve()) for root in settings.model_roots]

    @property
    def common(self) -> dict[str, Any]:
        """What every task is told: which robots may be loaded, and where copies of files are."""
        return {
            "library": {
                "model_roots": list(self._model_roots),
                "allow_paths": self._settings.may_load_paths,
                "copies": str(self._folder / "files"),
            }
        }

    async def scene_payload(self, record: SceneRecord) -> dict[str, Any]:
        """Return what a task is told of a scene."""
        file = await self._scenes.file(record)
        return {**self.common, "scene": {"digest": record.digest, "document": str(file)}}

    @property
    def library(self) -> LibraryWork:
        """What a task that loads robots is given."""
        return LibraryWork.model_validate(self.common)

    async def scene_work(self, record: SceneRecord) -> SceneWork:
        """Return what a task about a scene is given."""
        return SceneWork.model_validate(await self.scene_payload(record))

    async def call[In: BaseModel, Out: BaseModel](
        self, task: Task[In, Out], work: In, size: int = 0
    ) -> Out:
        """Have a worker carry out a short task and return its answer; raises as `ask`.

        Args:
            task: Of the queue of questions.
            work: What it is given.
            size: How much is asked: what is twice as much takes longer.
        """
        content = await self._ask(task.name, work.model_dump(mode="json"), size=size)
        return task.result.model_validate(content)

    async def call_text[In: BaseModel, Out: BaseModel](
        self, task: Task[In, Out], work: In, size: int = 0
    ) -> Encoded:
        """Call as `call` does, for an answer that is passed on as it is."""
        payload = work.model_dump(mode="json")
        found: Encoded = await self._ask(task.name, payload, size=size, is_passed_on=True)
        return found

    async def ask(self, task: str, payload: dict[str, Any], size: int = 0) -> Any:
        """Run a short task in the query lane and return its answer; it ends if the client leaves.

        Args:
            task: To run.
            payload: With `scene` where it is about one.
            size: How much is asked: what is twice as much takes longer.

        Raises:
            WayproofError: What the task raised, or that it took too long, or that it crashed, or
                that no worker was free in time.
            ClientLeft: Its client does not wait any more.
        """
        return await self._ask(task, payload, size=size)

    async def ask_text(self, task: str, payload: dict[str, Any]) -> Encoded:
        """Ask as `ask` does, for an answer that is passed on as it is."""
        found: Encoded = await self._ask(task, payload, is_passed_on=True)
        return found

    async def load[In: BaseModel](
        self, task: Task[In, LoadedScene], work: In, size: int = 0
    ) -> LoadedScene:
        """Call as `call` does, for a scene that the task loads."""
        payload = work.model_dump(mode="json")
        more = {"leaves": "digest", "is_in_parts": True}
        content = await self._ask(task.name, payload, size=size, **more)
        return LoadedScene.model_validate(content)

    async def _ask(self, task: str, payload: dict[str, Any], **more: Any) -> Any:
        allowed, patience = self._settings.query_timeout, self._settings.query_patience
        key = payload["scene"]["digest"] if "scene" in payload else None
        question = Question(task, payload, "query", allowed, patience, key, **more)
        answer = await unless_client_leaves(self._dispatcher.call(question))
        note_question(answer.waited, answer.worked)
        return answer.content

    async def ask_scene(self, task: str, record: SceneRecord, request: BaseModel) -> Any:
        """Ask a loaded scene something; raises as `ask`."""
        return await self.ask(task, *await self._about(record, request))

    async def _about(self, record: SceneRecord, request: BaseModel) -> tuple[dict[str, Any], int]:
        """Return the payload of a question to a scene, and how much it asks."""
        asked = request.model_dump(mode="json")
        payload = {**await self.scene_payload(record), "request": asked}
        return payload, sum(len(field) for field in asked.values() if isinstance(field, list))

    async def planners(self) -> list[Planner]:
        """Return all planners; they are asked for once, because they never change."""
        if not self._planners:
            self._planners = (await self.call(LIST_PLANNERS, NoWork())).items
        return self._planners

    async def submit(self, spec: JobSpec) -> Job:
        """Queue a job; it is durable when this returns.

        Raises:
            QueueFull: Its lane has as many waiting jobs as it may.
            IdempotencyConflict: Its key was used for another request.
        """
        return await self._dispatcher.submit(spec)

    async def known(self, spec: JobSpec) -> Job | None:
        """Return the job that the spec's idempotency key names, if there is one.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        if spec.key is None:
            return None
        asked = (spec.lane, spec.key, spec.request_digest)
        return await to_thread.run_sync(self._store.known, *asked)

    async def open_job(self, lane: str, identifier: str) -> JobBrief:
        """Return a job that waits or runs here as memory has it, any other one as lists have it.

        Raises:
            UnknownResource: The lane has none of that id.
        """
        run = self._dispatcher.live(identifier)
        if run is not None and run.job.lane == lane:
            return run.snapshot()
        return await self._read(lane, identifier, self._store.brief)

    async def job(self, lane: str, identifier: str) -> Job:
        """Return a job.

        Raises:
            UnknownResource: The lane has none of that id.
        """
        return await self._read(lane, identifier, self._store.get)

    async def job_text(self, lane: str, identifier: str) -> JobText:
        """Return a job whose result is passed on as it is; raises as `job`."""
        return await self._read(lane, identifier, self._store.text)

    async def _read[T](self, lane: str, identifier: str, read: Callable[[str], T]) -> T:
        if not identifier.startswith(f"{PREFIXES[lane]}_"):
            raise UnknownResource.of(lane, identifier)
        try:
            return await to_thread.run_sync(read, identifier)
        except UnknownJob as fault:
            raise UnknownResource.of(lane, identifier) from fault

    async def page(
        self,
        lane: str,
        limit: int,
        cursor: str | None,
        *,
        state: str | None = None,
        scene: str | None = None,
        warm_key: str | None = None,
    ) -> JobPage:
        """Return jobs of a lane, newest first, from a cursor on."""
        before = None if cursor is None else int(cursor)

        def read() -> list[JobBrief]:
            wanted = {"state": state, "scene": scene, "warm_key": warm_key}
            return self._store.page(lane, wanted, before=before, limit=limit + 1)

        found = await to_thread.run_sync(read)
        following = str(found[limit - 1].serial) if len(found) > limit else None
        return JobPage(found[:limit], following)

    async def newest(
        self, lane: str, *, scene: str | None = None, warm_key: str | None = None
    ) -> AsyncIterator[JobBrief]:
        """Yield the jobs of a lane in a scene, or with a scene's content, newest first."""
        wanted = {"scene": scene, "warm_key": warm_key}
        before: int | None = None
        limit = 1
        # Mostly the first one is what somebody looks for.
        while True:
            read = partial(self._store.page, lane, wanted, before=before, limit=limit)
            found = await to_thread.run_sync(read)
            for job in found:
                yield job
            if len(found) < limit:
                return
            before, limit = found[-1].serial, min(2 * limit, _CHUNK)

    async def in_scene(self, lane: str, scene: str) -> JobBrief | None:
        """Return a job of a lane that waits or runs in a scene, if there is one."""
        # In the order of its life: one that begins between the two looks is seen by the second.
        for state in ("queued", "running"):
            page = await self.page(lane, 1, None, state=state, scene=scene)
            if page.jobs:
                return page.jobs[0]
        return None

    async def wait(self, job: Job, seconds: float) -> JobText:
        """Return a job when it has ended, or as it is after so many seconds."""
        if seconds > 0:
            return await self._dispatcher.wait_text(job.id, seconds)
        return await self.text_of(job)

    async def text_of(self, job: JobBrief) -> JobText:
        """Return a job with its result, if it has one."""
        has_one = job.state is JobState.SUCCEEDED
        return await self.job_text(job.lane, job.id) if has_one else JobText(job, None)

    async def cancel(self, job: JobBrief) -> JobBrief:
        """Ask for the end of a job, whatever its state; no database is waited for."""
        return await self._dispatcher.cancel(job.id)

    async def control(self, job: JobBrief, asked: dict[str, Any]) -> Job:
        """Ask something of a job that waits or runs; no database is waited for.

        Raises:
            IllegalTransition: It has ended, or is to end.
        """
        return await self._dispatcher.control(job.id, asked)

    def unrecorded(self, job: JobBrief) -> list[str]:
        """Return what has happened to a job and is not in the database yet."""
        run = None if job.state.is_final else self._dispatcher.live(job.id)
        return [] if run is None else run.unrecorded

    def begin_to_stop(self) -> None:
        """Begin nothing more, and tell what runs to end, before `Dispatcher.stop` waits for it."""
        self._dispatcher.begin_to_stop()

    async def events(self, job: JobBrief, after: int) -> AsyncIterator[LoggedEvent]:
        """Yield a job's events with numbers above `after`, until it has ended."""
        async for event in self._dispatcher.subscribe(job.id, after):
            yield event

    async def last_told(self, job: JobBrief, event_type: str) -> dict[str, Any] | None:
        """Return the data of the newest event of a type, recorded or not, if there is one."""
        run = self._dispatcher.live(job.id)
        if run is not None:
            return run.latest(event_type)
        event = await to_thread.run_sync(self._store.last_event, job.id, event_type)
        return None if event is None else event.data

    def require_ready(self) -> None:
        """Go on only if workers of every lane are warm.

        Raises:
            NotReady: They are not, yet or any more.
        """
        faults = self._dispatcher.faults()
        if faults:
            named = "; ".join(f"{lane}: {fault}" for lane, fault in faults.items())
            raise NotReady(f"not ready: {named}"[:500], {"faults": faults, "retry_after": 1})

    async def counts(self) -> dict[str, dict[str, int]]:
        """Return how many jobs there are, by state and lane."""
        found = await to_thread.run_sync(self._store.counts)
        counts: dict[str, dict[str, int]] = {
            state: dict.fromkeys(LANES, 0)
            for state in ("queued", "running", "succeeded", "failed", "canceled")
        }
        for (lane, state), number in found.items():
            counts[state][lane] = number
        return counts

    @property
    def best_grace(self) -> float:
        """How long a canceled plan may time and prove its best path so far [s]."""
        return self._settings.best_grace

    @property
    def regions_folder(self) -> Path:
        """Where slots read regions; the files are a copy of what the database has."""
        return self._folder / "regions"

    @property
    def roadmaps(self) -> str:
        """The folder of roadmaps that outlive a worker."""
        return str(self._folder / "roadmaps")

    @property
    def cores(self) -> dict[str, Any] | None:
        """Through which files plans share the processors; None where tasks run in threads."""
        if self._settings.engine == "inline":
            return None
        folder = str(self._folder / "cores")
        return {"folder": folder, "count": self._settings.search_processes}
