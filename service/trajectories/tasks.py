"""Tasks about motions of the client."""

from service.jobs.task import Task
from service.scenes.tasks import RequestWork
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

RETIME = Task("retime_path", RequestWork[RetimeRequest], RetimeResponse)
CERTIFY = Task("certify_trajectory", RequestWork[CertifyMotionRequest], CertifyMotionResponse)
STOP = Task("stop_motion", RequestWork[StopMotionRequest], StopMotionResponse)
SPLICE = Task("splice_motion", RequestWork[SpliceMotionRequest], SpliceMotionResponse)
