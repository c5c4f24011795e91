"""Tasks that answer questions to a scene."""

from typing import Self

from pydantic import BaseModel

from service.jobs.task import Task
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.scenes.tasks import SceneWork


class QueryWork[Request: BaseModel](SceneWork):
    """A question to a scene."""

    request: Request

    @classmethod
    def about(cls, scene: SceneWork, request: Request) -> Self:
        """Return a question with what every task about a scene is given."""
        return cls(library=scene.library, scene=scene.scene, request=request)


CHECK = Task("check", QueryWork[CheckRequest], CheckResponse)
FK = Task("fk", QueryWork[FkRequest], FkResponse)
IK = Task("ik", QueryWork[IkRequest], IkResponse)
LINE = Task("line", QueryWork[LineRequest], LineResponse)
