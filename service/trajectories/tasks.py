"""Tasks about motions of the client."""

from service.api.models import RequestModel
from service.jobs.task import Task
from service.scenes.tasks import SceneWork
from service.trajectories.models import (
    CertifyMotionRequest,
    CertifyMotionResponse,
    RetimeRequest,
    RetimeResponse,
    SpliceMotionRequest,
    SpliceMotionResponse,
    StopMotionRequest,
    StopMotionResponse,
)


class MotionWork[Request: RequestModel](SceneWork):
    """A request about a motion, in a scene."""

    request: Request


RETIME = Task("retime_path", MotionWork[RetimeRequest], RetimeResponse)
CERTIFY = Task("certify_trajectory", MotionWork[CertifyMotionRequest], CertifyMotionResponse)
STOP = Task("stop_motion", MotionWork[StopMotionRequest], StopMotionResponse)
SPLICE = Task("splice_motion", MotionWork[SpliceMotionRequest], SpliceMotionResponse)
