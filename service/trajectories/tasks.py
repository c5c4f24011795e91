"""Tasks about motions of the client."""

from service.jobs.task import Task, TaskModel
from service.plans.models.trajectory import Polynomial
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
from service.trajectories.schedule_models import ScheduleMotionsRequest, ScheduleMotionsResponse


class PlannedMotion(TaskModel):
    """The motion of a plan."""

    group: str
    trajectory: Polynomial


class ScheduleWork(RequestWork[ScheduleMotionsRequest]):
    """Motions that move at the same time, the most urgent first."""

    motions: list[PlannedMotion]


RETIME = Task("retime_path", RequestWork[RetimeRequest], RetimeResponse)
CERTIFY = Task("certify_trajectory", RequestWork[CertifyMotionRequest], CertifyMotionResponse)
STOP = Task("stop_motion", RequestWork[StopMotionRequest], StopMotionResponse)
SPLICE = Task("splice_motion", RequestWork[SpliceMotionRequest], SpliceMotionResponse)
SCHEDULE = Task("schedule_motions", ScheduleWork, ScheduleMotionsResponse)
