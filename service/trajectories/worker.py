"""Motions of the client, carried out: timed, certified, stopped and spliced."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypedDict

import numpy as np

from planning import (
    Deadline,
    RetimeOptions,
    TimedTrajectory,
    World,
    certify_trajectory,
    retime_path,
    splice_motion,
    stop_motion,
)
from planning.api.certify_trajectory import certify_positions
from planning.api.sample_motion import sample_motion
from planning.api.splice_motion import ProvenMotion
from planning.domain.request.constraint import PathConstraint
from planning.domain.robot.joints import JointGroup
from planning.errors import PlanningFailure, ProblemInvalid
from service.api.failures.failure import Failure
from service.jobs.context import TaskContext
from service.plans.models.constraints import constraints_to_domain
from service.plans.models.motion_limits import ScaledLimits
from service.plans.models.reports import CertifyReport, RetimeReport
from service.plans.models.result import Certificate
from service.plans.models.sampling import IN_QUESTION, require_few
from service.plans.models.trajectory import Trajectory
from service.scenes.world_cache import borrow_world
from service.trajectories.input import MotionInterpolation, TrajectoryInput
from service.trajectories.models import (
    CertifyMotionRequest,
    CertifyMotionResponse,
    MotionRequest,
    RetimeRequest,
    RetimeResponse,
    RetimeStages,
    SpliceMotionRequest,
    SpliceMotionResponse,
    StopMotionRequest,
    StopMotionResponse,
)
from service.trajectories.tasks import CERTIFY, RETIME, SPLICE, STOP, MotionWork


class _Demands(TypedDict):
    """What a motion must keep, as the functions of planning take it."""

    options: RetimeOptions
    constraints: tuple[PathConstraint, ...]
    margin: float | None


@RETIME.runs
def retime(work: MotionWork[RetimeRequest], context: TaskContext) -> RetimeResponse:
    """Return a certified motion along the path, or why there is none.

    Raises:
        InputError: The group or the waypoints do not fit the scene.
    """
    request = work.request
    sampling = request.retime.sampling
    demands = _demands(request, request.retime.to_domain())
    cut_samples: list[str] = []
    with borrow_world(work) as world:
        deadline = _deadline(request, context)
        try:
            motion = retime_path(
                world,
                request.group,
                np.array(request.waypoints, dtype=np.float64),
                deadline=deadline,
                certify_options=request.certify.to_domain(),
                **demands,
            )
        except PlanningFailure as failure:
            why = Failure.from_error(failure)
            return RetimeResponse(trajectory=None, certificate=None, stages=None, failure=why)
        require_few(motion.trajectory, sampling)
        samples = sample_motion(
            world,
            request.group,
            motion.trajectory,
            sampling,
            deadline=deadline.with_on_expiry(lambda: cut_samples.append("samples")),
            clearance=motion.certificate.proven_clearance,
            **demands,
        )
    return RetimeResponse(
        trajectory=Trajectory.from_samples(
            samples.samples,
            samples.interpolations,
            motion.trajectory if request.polynomial else None,
        ),
        certificate=Certificate.from_domain(motion.certificate),
        stages=RetimeStages(
            retime=RetimeReport.model_validate(motion.retime),
            certify=CertifyReport.model_validate(motion.certify),
        ),
        cut_short=[*motion.cut_short, *cut_samples[:1]],
        failure=None,
    )


@CERTIFY.runs
def certify(work: MotionWork[CertifyMotionRequest], context: TaskContext) -> CertifyMotionResponse:
    """Return the certificate of a trajectory.

    Raises:
        InputError: The group or the trajectory do not fit the scene.
        DeadlineExceeded: Time ran out before the verdict.
    """
    request = work.request
    options = _options(request, limit_jerk=request.limit_jerk)
    with borrow_world(work) as world:
        deadline = _deadline(request, context)
        trajectory, kind = request.trajectory.to_domain(world.group(request.group))
        motion = (world, request.group, trajectory)
        ends = {"start": request.start, "goal": request.goal}
        demands = _demands(request, options)
        unchecked: tuple[str, ...] = ()
        if kind == "linear":
            certificate, report, unchecked = certify_positions(
                *motion, deadline=deadline, **ends, **demands
            )
        else:
            certify_options = request.certify.to_domain()
            certificate, report = certify_trajectory(
                *motion, deadline=deadline, certify_options=certify_options, **ends, **demands
            )
    return CertifyMotionResponse(
        certificate=Certificate.from_domain(certificate),
        interpolation=kind,
        unchecked=list(unchecked),
        duration=trajectory.duration,
        stage=CertifyReport.model_validate(report),
    )


@STOP.runs
def stop(work: MotionWork[StopMotionRequest], context: TaskContext) -> StopMotionResponse:
    """Return a certified stop, or why there is none.

    Raises:
        InputError: The group, the motion, the instant or a limit do not fit the scene.
    """
    request = work.request
    demands = _demands(request, _options(request, limit_jerk=request.limit_jerk))
    with borrow_world(work) as world:
        running, kind = _smooth(request.trajectory, world.group(request.group), "trajectory")
        deadline = _deadline(request, context)
        transition = _Transition(request, world, running, deadline, demands)
        along = request.along_path
        motion = (world, request.group, running, request.time)
        answer = transition.answer(
            lambda: stop_motion(*motion, along_path=along, deadline=deadline, **demands)
        )
    return StopMotionResponse(**answer, interpolation=kind)


@SPLICE.runs
def splice(work: MotionWork[SpliceMotionRequest], context: TaskContext) -> SpliceMotionResponse:
    """Return a certified way over into another motion and that motion's rest, or why there is none.

    Raises:
        InputError: The group, a motion, the instant or a limit do not fit the scene.
    """
    request = work.request
    demands = _demands(request, _options(request, limit_jerk=True))
    with borrow_world(work) as world:
        group = world.group(request.group)
        running, kind = _smooth(request.trajectory, group, "trajectory")
        onto, onto_kind = _smooth(request.onto, group, "onto")
        deadline = _deadline(request, context)
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
    demands: _Demands

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


def _deadline(request: MotionRequest, context: TaskContext) -> Deadline:
    return Deadline.after(request.allowed_time, time.monotonic, context.is_canceled)


def _options(limits: ScaledLimits, *, limit_jerk: bool) -> RetimeOptions:
    method: Literal["ruckig", "toppra"] = "ruckig" if limit_jerk else "toppra"
    return RetimeOptions(method=method, **limits.limit_fields())


def _demands(request: MotionRequest, options: RetimeOptions) -> _Demands:
    constraints = constraints_to_domain(request.path_constraints)
    return _Demands(options=options, constraints=constraints, margin=request.margin)
