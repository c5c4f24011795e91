"""Motions of the client that are left: for a stand, or for another motion."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypedDict

from planning import (
    Deadline,
    TimedTrajectory,
    World,
    splice_motion,
    stop_motion,
)
from planning.api.sample_motion import sample_motion
from planning.api.splice_motion import ProvenMotion
from planning.domain.robot.joints import JointGroup
from planning.errors import PlanningFailure, ProblemInvalid
from service.api.failures.failure import Failure
from service.jobs.context import TaskContext
from service.plans.models.reports import CertifyReport
from service.plans.models.result import Certificate
from service.plans.models.sampling import IN_QUESTION, require_few
from service.plans.models.trajectory import Trajectory
from service.scenes.tasks import RequestWork
from service.scenes.world_cache import borrow_world
from service.trajectories.demands import MotionDemands, deadline_of, demands_of, options_of
from service.trajectories.input import MotionInterpolation, TrajectoryInput
from service.trajectories.models import (
    SpliceMotionRequest,
    SpliceMotionResponse,
    StopMotionRequest,
    StopMotionResponse,
)
from service.trajectories.tasks import SPLICE, STOP


@STOP.runs
def stop(work: RequestWork[StopMotionRequest], context: TaskContext) -> StopMotionResponse:
    """Return a certified stop, or why there is none.

    Raises:
        InputError: The group, the motion, the instant or a limit do not fit the scene.
    """
    request = work.request
    demands = demands_of(request, options_of(request, limit_jerk=request.limit_jerk))
    with borrow_world(work) as world:
        running, kind = _smooth(request.trajectory, world.group(request.group), "trajectory")
        deadline = deadline_of(request, context)
        transition = _Transition(request, world, running, deadline, demands)
        along = request.along_path
        motion = (world, request.group, running, request.time)
        answer = transition.answer(
            lambda: stop_motion(*motion, along_path=along, deadline=deadline, **demands)
        )
    return StopMotionResponse(**answer, interpolation=kind)


@SPLICE.runs
def splice(work: RequestWork[SpliceMotionRequest], context: TaskContext) -> SpliceMotionResponse:
    """Return a certified way over into another motion and that motion's rest, or why there is none.

    Raises:
        InputError: The group, a motion, the instant or a limit do not fit the scene.
    """
    request = work.request
    demands = demands_of(request, options_of(request, limit_jerk=True))
    with borrow_world(work) as world:
        group = world.group(request.group)
        running, kind = _smooth(request.trajectory, group, "trajectory")
        onto, onto_kind = _smooth(request.onto, group, "onto")
        deadline = deadline_of(request, context)
        transition = _Transition(request, world, running, deadline, demands)
        motion = (world, request.group, running, request.time, onto)
        answer = transition.answer(lambda: splice_motion(*motion, deadline=deadline, **demands))
    return SpliceMotionResponse(**answer, interpolation=kind, onto_interpolation=onto_kind)


class _Answer(TypedDict):
    """Fields that answers about transitions share."""

    trajectory: Trajectory | None
    certificate: Certificate | None
    stage: CertifyReport | None
    failure: Failure | None


@dataclass(frozen=True)
class _Transition:
    """A running motion that is left for a stand or for another motion."""

    request: StopMotionRequest | SpliceMotionRequest
    world: World
    running: TimedTrajectory
    deadline: Deadline
    demands: MotionDemands

    def answer(self, find: Callable[[], ProvenMotion]) -> _Answer:
        """Return the motion that is found, with its samples, or why there is none."""
        request = self.request
        try:
            motion = find()
        except PlanningFailure as failure:
            why = Failure.from_error(failure)
            return _Answer(trajectory=None, certificate=None, stage=None, failure=why)
        require_few(motion.trajectory, request.sampling, IN_QUESTION)
        samples = sample_motion(
            self.world,
            request.group,
            motion.trajectory,
            request.sampling,
            deadline=self.deadline,
            clearance=motion.certificate.proven_clearance,
            origin=self.running.start,
            **self.demands,
        )
        return _Answer(
            trajectory=Trajectory.from_samples(
                samples.samples,
                samples.interpolations,
                motion.trajectory if request.polynomial else None,
            ),
            certificate=Certificate.from_domain(motion.certificate),
            stage=CertifyReport.model_validate(motion.certify),
            failure=None,
        )


def _smooth(
    trajectory: TrajectoryInput, group: JointGroup, field: str
) -> tuple[TimedTrajectory, MotionInterpolation]:
    """Return a motion that can be left or joined, and the interpolation of its samples.

    Raises:
        InputError: It does not fit the group, or has corners.
    """
    motion, kind = trajectory.to_domain(group, field)
    if kind == "linear":
        message = f"{field}.interpolation: straight lines have corners, where nothing can be joined"
        raise ProblemInvalid(message, {"field": f"{field}.interpolation"})
    return motion, kind
