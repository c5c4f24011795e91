"""Motions of the client: timed, and certified."""

import numpy as np

from planning import (
    certify_trajectory,
    retime_path,
)
from planning.api.certify_trajectory import certify_positions
from planning.api.sample_motion import sample_motion
from planning.errors import PlanningFailure
from service.api.failures.failure import Failure
from service.jobs.context import TaskContext
from service.plans.models.reports import CertifyReport, RetimeReport
from service.plans.models.result import Certificate
from service.plans.models.sampling import require_few
from service.plans.models.trajectory import Trajectory
from service.scenes.tasks import RequestWork
from service.scenes.world_cache import borrow_world
from service.trajectories.demands import deadline_of, demands_of, options_of
from service.trajectories.models import (
    CertifyMotionRequest,
    CertifyMotionResponse,
    RetimeRequest,
    RetimeResponse,
    RetimeStages,
)
from service.trajectories.tasks import CERTIFY, RETIME


@RETIME.runs
def retime(work: RequestWork[RetimeRequest], context: TaskContext) -> RetimeResponse:
    """Return a certified motion along the path, or why there is none.

    Raises:
        InputError: The group or the waypoints do not fit the scene.
    """
    request = work.request
    sampling = request.retime.sampling
    demands = demands_of(request, request.retime.to_domain())
    cut_samples: list[str] = []
    with borrow_world(work) as world:
        deadline = deadline_of(request, context)
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
def certify(work: RequestWork[CertifyMotionRequest], context: TaskContext) -> CertifyMotionResponse:
    """Return the certificate of a trajectory.

    Raises:
        InputError: The group or the trajectory do not fit the scene.
        DeadlineExceeded: Time ran out before the verdict.
    """
    request = work.request
    options = options_of(request, limit_jerk=request.limit_jerk)
    with borrow_world(work) as world:
        deadline = deadline_of(request, context)
        trajectory, kind = request.trajectory.to_domain(world.group(request.group))
        motion = (world, request.group, trajectory)
        ends = {"start": request.start, "goal": request.goal}
        demands = demands_of(request, options)
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
