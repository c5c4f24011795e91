"""/v1/scenes/{id}/check, fk, ik, line: questions to a scene."""

from fastapi import APIRouter, Response

from service.api.params import SceneId
from service.api.responses import passed_on, problems
from service.api.strict_route import StrictRoute
from service.dependencies import JobsDep, ScenesDep
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.queries.tasks import CHECK, FK, IK, LINE, QueryWork
from service.scenes.validation import (
    require_constraints,
    require_count,
    require_frames,
    require_goal,
    require_group,
    require_joints,
)

router = APIRouter(
    route_class=StrictRoute,
    prefix="/v1/scenes/{scene}",
    tags=["queries"],
    responses=problems(400, 404, 409, 413, 422, 429, 503),
)


@router.post("/check", operation_id="checkConfigurations", response_model=CheckResponse)
async def check(
    scene: SceneId, request: CheckRequest, scenes: ScenesDep, desk: JobsDep
) -> Response:
    """Check configurations: limits, and every pair of bodies that collides, with its depth."""
    record = await scenes.get(scene)
    group = require_group(record, request.group)
    for i, q in enumerate(request.configurations):
        require_count(group, q, f"configurations.{i}")
    work = QueryWork[CheckRequest].about(await desk.scene_work(record), request)
    return passed_on(await desk.call_text(CHECK, work, size=len(request.configurations)))


@router.post("/fk", operation_id="computeForwardKinematics", response_model=FkResponse)
async def fk(scene: SceneId, request: FkRequest, scenes: ScenesDep, desk: JobsDep) -> Response:
    """Compute where frames are in given configurations."""
    record = await scenes.get(scene)
    group = require_group(record, request.group)
    require_frames(record, request.frames or [])
    for i, q in enumerate(request.configurations):
        require_count(group, q, f"configurations.{i}")
    work = QueryWork[FkRequest].about(await desk.scene_work(record), request)
    return passed_on(await desk.call_text(FK, work, size=len(request.configurations)))


@router.post("/ik", operation_id="solveInverseKinematics", response_model=IkResponse)
async def ik(scene: SceneId, request: IkRequest, scenes: ScenesDep, desk: JobsDep) -> Response:
    """Find all distinct configurations that reach a goal, or say why there is none."""
    record = await scenes.get(scene)
    group = require_group(record, request.group)
    require_goal(record, group, request.goal)
    require_constraints(record, group, request.path_constraints)
    require_joints(group, request.ik.joint_weights)
    if request.start is not None:
        require_count(group, request.start, "start")
    work = QueryWork[IkRequest].about(await desk.scene_work(record), request)
    return passed_on(await desk.call_text(IK, work))


@router.post("/line", operation_id="traceLine", response_model=LineResponse)
async def line(scene: SceneId, request: LineRequest, scenes: ScenesDep, desk: JobsDep) -> Response:
    """Move a tool in a straight line as far as it goes, and say exactly why it stops."""
    record = await scenes.get(scene)
    group = require_group(record, request.group)
    ends = [end.frame for end in (request.pose, request.displacement) if end is not None]
    require_frames(record, [*ends, *([] if request.frame is None else [request.frame])])
    if request.start is not None:
        require_count(group, request.start, "start")
    work = QueryWork[LineRequest].about(await desk.scene_work(record), request)
    return passed_on(await desk.call_text(LINE, work))
