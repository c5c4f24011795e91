"""Tasks that answer questions to a scene."""

from service.jobs.task import Task
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.scenes.tasks import RequestWork

CHECK = Task("check", RequestWork[CheckRequest], CheckResponse)
FK = Task("fk", RequestWork[FkRequest], FkResponse)
IK = Task("ik", RequestWork[IkRequest], IkResponse)
LINE = Task("line", RequestWork[LineRequest], LineResponse)
