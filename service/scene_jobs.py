"""JobService: jobs and questions about scenes, and what tasks are told of scenes and settings."""

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from service.api.client_disconnect import note_question, unless_client_leaves
from service.catalog.models import Planner
from service.catalog.tasks import LIST_PLANNERS, NoWork
from service.job_spec import PREFIXES
from service.jobs.calls import Call
from service.jobs.dispatcher import Dispatcher
from service.jobs.json_text import Encoded
from service.jobs.service import JobService
from service.jobs.store import JobStore
from service.jobs.task import Task
from service.scenes.records import SceneRecord
from service.scenes.store import SceneStore
from service.scenes.tasks import LibraryWork, LoadedScene, SceneWork
from service.settings import Settings

QUEUES = ("plan", "query", "execution", "regions")


class JobService(JobService):
    """Jobs, and questions that scenes answer at once, from coroutines of one event loop."""

    def __init__(
        self, settings: Settings, store: JobStore, dispatcher: Dispatcher, scenes: SceneStore
    ) -> None:
        """Put the parts together; the dispatcher runs already."""
        super().__init__(store, dispatcher, prefixes=PREFIXES, queues=QUEUES)
        self._settings = settings
        self._scenes = scenes
        self._planners: list[Planner] = []
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
        found: Encoded = await self._ask(task.name, payload, size=size, is_raw=True)
        return found

    async def ask(self, task: str, payload: dict[str, Any], size: int = 0) -> Any:
        """Run a short task in the query queue and return its answer; it ends if the client leaves.

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
        found: Encoded = await self._ask(task, payload, is_raw=True)
        return found

    async def load[In: BaseModel](
        self, task: Task[In, LoadedScene], work: In, size: int = 0
    ) -> LoadedScene:
        """Call as `call` does, for a scene that the task loads."""
        payload = work.model_dump(mode="json")
        more = {"digest_field": "digest", "is_partly_raw": True}
        content = await self._ask(task.name, payload, size=size, **more)
        return LoadedScene.model_validate(content)

    async def _ask(self, task: str, payload: dict[str, Any], **more: Any) -> Any:
        time_limit, worker_timeout = self._settings.query_timeout, self._settings.query_patience
        digest = payload["scene"]["digest"] if "scene" in payload else None
        call = Call(task, payload, "query", time_limit, worker_timeout, digest, **more)
        answer = await unless_client_leaves(self._dispatcher.call(call))
        note_question(answer.waited, answer.worked)
        return answer.content

    async def ask_scene(self, task: str, record: SceneRecord, request: BaseModel) -> Any:
        """Ask a loaded scene something; raises as `ask`."""
        return await self.ask(task, *await self._about(record, request))

    async def _about(self, record: SceneRecord, request: BaseModel) -> tuple[dict[str, Any], int]:
        """Return the payload of a question to a scene, and how much it asks."""
        fields = request.model_dump(mode="json")
        payload = {**await self.scene_payload(record), "request": fields}
        return payload, sum(len(field) for field in fields.values() if isinstance(field, list))

    async def planners(self) -> list[Planner]:
        """Return all planners; they are asked for once, because they never change."""
        if not self._planners:
            self._planners = (await self.call(LIST_PLANNERS, NoWork())).items
        return self._planners

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
