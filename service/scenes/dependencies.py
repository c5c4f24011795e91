"""What endpoints about scenes are handed."""

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import Depends, Response
from fastapi.requests import HTTPConnection
from pydantic import BaseModel

from service.api.dependencies import JobsDep
from service.api.responses import passed_on
from service.jobs.service import JobService
from service.jobs.task import Task
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.tasks import RequestWork


def scenes_of(connection: HTTPConnection) -> SceneStore:
    """Return the scenes of the server that a request is sent to."""
    scenes: SceneStore = connection.app.state.scenes
    return scenes


async def _scenes(connection: HTTPConnection) -> SceneStore:
    return scenes_of(connection)


type ScenesDep = Annotated[SceneStore, Depends(_scenes)]

REVISION = "wayproof-revision"
# Of answers to questions about a scene.
WITH_REVISION: dict[str, Any] = {
    "headers": {
        REVISION: {
            "description": "Revision of the scene that the answer is about",
            "schema": {"type": "integer"},
        }
    }
}


@dataclass(frozen=True)
class SceneCalls:
    """Short tasks about scenes.

    Attributes:
        scenes: That they are about.
        jobs: Calls them.
    """

    scenes: SceneStore
    jobs: JobService

    async def answer[In: BaseModel, Out: BaseModel](
        self, task: Task[RequestWork[In], Out], record: SceneRecord, request: In, size: int = 0
    ) -> Response:
        """Return the answer of a task to a request about a scene, passed on as it is.

        A header says of which revision it is: the latest may be another one by now.

        Args:
            task: Of a queue of calls.
            record: Of the scene.
            request: Whose names are known to be there.
            size: Number of items: twice as many take longer.
        """
        work = task.payload.about(self.scenes.work(record), request)
        told = await self.jobs.call_text(task, work, size)
        return passed_on(told, headers={REVISION: str(record.revision)})


async def _scene_calls(scenes: ScenesDep, jobs: JobsDep) -> SceneCalls:
    return SceneCalls(scenes, jobs)


type SceneCallsDep = Annotated[SceneCalls, Depends(_scene_calls)]
