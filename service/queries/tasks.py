"""Tasks that answer questions to a scene."""

from service.jobs.task import Task, TaskModel
from service.plans.tasks import Page
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.geometry import Geometry, MeshRequest
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.scenes.tasks import RequestWork, SceneWork


class MeshContent(TaskModel):
    """A mesh.

    Attributes:
        glb: Its bytes in base64; None if the scene has no such mesh.
    """

    glb: str | None


CHECK = Task("check", RequestWork[CheckRequest], CheckResponse)
FK = Task("fk", RequestWork[FkRequest], FkResponse)
IK = Task("ik", RequestWork[IkRequest], IkResponse)
LINE = Task("line", RequestWork[LineRequest], LineResponse)
GEOMETRY = Task("geometry", SceneWork, Geometry)
VIEW = Task("view_scene", SceneWork, Page)
MESH = Task("mesh", RequestWork[MeshRequest], MeshContent)
