"""/v1/trajectories: time, certify, stop and splice motions of the client."""

from fastapi import APIRouter, Response

from service.api.responses import passed_on, problems
from service.api.routing.strict_route import StrictRoute
from service.plans.models.sampling import IN_QUESTION, require_one_sampling
from service.scenes.dependencies import REVISION, WITH_REVISION, SceneCallsDep
from service.scenes.store.records import SceneRecord
from service.scenes.validation import check_request
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
from service.trajectories.planned_motions import planned_motions
from service.trajectories.schedule_models import ScheduleMotionsRequest, ScheduleMotionsResponse
from service.trajectories.tasks import CERTIFY, RETIME, SCHEDULE, SPLICE, STOP, ScheduleWork

router = APIRouter(
    route_class=StrictRoute,
    prefix="/v1/trajectories",
    tags=["trajectories"],
    responses={200: WITH_REVISION, **problems(400, 404, 409, 413, 422, 429, 503)},
)


@router.post("/retime", operation_id="retimePath", response_model=RetimeResponse)
async def retime(request: RetimeRequest, calls: SceneCallsDep) -> Response:
    """Time a path of your own as quickly as the limits allow, and prove the motion."""
    record = await calls.scenes.get(request.scene, request.revision)
    request.retime.check_group(check_request(record, request))
    require_one_sampling(request.retime.sample_period, request.retime.num_points)
    return await calls.answer(RETIME, record, request, len(request.waypoints))


@router.post("/certify", operation_id="certifyTrajectory", response_model=CertifyMotionResponse)
async def certify(request: CertifyMotionRequest, calls: SceneCallsDep) -> Response:
    """Hold a trajectory of your own against limits and obstacles, between its samples too."""
    record = await calls.scenes.get(request.scene, request.revision)
    request.check_group(check_request(record, request))
    return await calls.answer(CERTIFY, record, request, len(request.trajectory.times))


@router.post("/stop", operation_id="stopMotion", response_model=StopMotionResponse)
async def stop(request: StopMotionRequest, calls: SceneCallsDep) -> Response:
    """Stop a running motion from an instant of it, as quickly as the limits allow, and prove it."""
    record = await calls.scenes.get(request.scene, request.revision)
    _check_transition(record, request)
    return await calls.answer(STOP, record, request, len(request.trajectory.times))


@router.post("/splice", operation_id="spliceMotion", response_model=SpliceMotionResponse)
async def splice(request: SpliceMotionRequest, calls: SceneCallsDep) -> Response:
    """Go over from a running motion to another one without a rest in between, and prove it."""
    record = await calls.scenes.get(request.scene, request.revision)
    _check_transition(record, request)
    return await calls.answer(SPLICE, record, request, len(request.trajectory.times))


@router.post("/schedule", operation_id="scheduleMotions", response_model=ScheduleMotionsResponse)
async def schedule(request: ScheduleMotionsRequest, calls: SceneCallsDep) -> Response:
    """Begin the motions of several plans as early as they can, and prove all of them together."""
    record = await calls.scenes.get(request.scene, request.revision)
    motions = await planned_motions(calls.jobs, record, request.plans)
    scene = calls.scenes.work(record)
    work = ScheduleWork(library=scene.library, scene=scene.scene, request=request, motions=motions)
    told = await calls.jobs.call_text(SCHEDULE, work, len(motions))
    return passed_on(told, headers={REVISION: str(record.revision)})


def _check_transition(
    record: SceneRecord, request: StopMotionRequest | SpliceMotionRequest
) -> None:
    request.check_group(check_request(record, request))
    require_one_sampling(request.sample_period, request.num_points, IN_QUESTION)
