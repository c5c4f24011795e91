"""/v1/trajectories: bring your own path or trajectory."""

from fastapi import APIRouter

from service.api.responses import problems
from service.api.strict_route import StrictRoute
from service.dependencies import JobsDep, ScenesDep
from service.plans.models.trajectory_conversion import IN_QUESTION, require_one_sampling
from service.scenes.records import SceneRecord
from service.scenes.validation import (
    Group,
    require_constraints,
    require_count,
    require_group,
    require_motion_limits,
)
from service.trajectories.models import (
    CertifyMotionRequest,
    CertifyMotionResponse,
    RetimeRequest,
    RetimeResponse,
)
from service.trajectories.transition_models import (
    SpliceMotionRequest,
    SpliceMotionResponse,
    StopMotionRequest,
    StopMotionResponse,
)

router = APIRouter(
    route_class=StrictRoute,
    prefix="/v1/trajectories",
    tags=["trajectories"],
    responses=problems(400, 404, 409, 413, 422, 429, 503),
)


@router.post("/retime", operation_id="retimePath", response_model=RetimeResponse)
async def retime(request: RetimeRequest, scenes: ScenesDep, desk: JobsDep) -> object:
    """Time a path of your own as quickly as the limits allow, and prove the motion."""
    record = await scenes.get(request.scene, request.revision)
    group = require_group(record, request.group)
    for i, q in enumerate(request.waypoints):
        require_count(group, q, f"waypoints.{i}")
    require_motion_limits(record, group, request.retime)
    require_one_sampling(request.retime.sample_period, request.retime.num_points)
    return await desk.ask_scene("service.trajectories.worker:retime", record, request)


@router.post("/certify", operation_id="certifyTrajectory", response_model=CertifyMotionResponse)
async def certify(request: CertifyMotionRequest, scenes: ScenesDep, desk: JobsDep) -> object:
    """Hold a trajectory of your own against limits and obstacles, between its samples too."""
    record = await scenes.get(request.scene, request.revision)
    group = require_group(record, request.group)
    for field, q in (("start", request.start), ("goal", request.goal)):
        if q is not None:
            require_count(group, q, field)
    require_motion_limits(record, group, request)
    return await desk.ask_scene("service.trajectories.worker:certify", record, request)


@router.post("/stop", operation_id="stopMotion", response_model=StopMotionResponse)
async def stop(request: StopMotionRequest, scenes: ScenesDep, desk: JobsDep) -> object:
    """Stop a running motion from an instant of it, as quickly as the limits allow, and prove it."""
    record = await scenes.get(request.scene, request.revision)
    _require_leaving(record, require_group(record, request.group), request)
    return await desk.ask_scene("service.trajectories.transitions:stop", record, request)


@router.post("/splice", operation_id="spliceMotion", response_model=SpliceMotionResponse)
async def splice(request: SpliceMotionRequest, scenes: ScenesDep, desk: JobsDep) -> object:
    """Go over from a running motion to another one without a rest in between, and prove it."""
    record = await scenes.get(request.scene, request.revision)
    _require_leaving(record, require_group(record, request.group), request)
    return await desk.ask_scene("service.trajectories.transitions:splice", record, request)


def _require_leaving(
    record: SceneRecord, group: Group, request: StopMotionRequest | SpliceMotionRequest
) -> None:
    require_constraints(record, group, request.path_constraints)
    require_motion_limits(record, group, request)
    require_one_sampling(request.sample_period, request.num_points, IN_QUESTION)
