"""/v1/scenes/{id}/check, fk, ik, line: questions to a scene."""

from fastapi import APIRouter, Response

from service.api.dependencies import JobsDep
from service.api.params import Revision, SceneId
from service.api.responses import passed_on, problems
from service.api.strict_route import StrictRoute
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.queries.tasks import CHECK, FK, IK, LINE, QueryWork
from service.scenes.dependencies import ScenesDep
from service.scenes.validation import check_request

router = APIRouter(
    route_class=StrictRoute,
    prefix="/v1/scenes/{scene}",
    tags=["queries"],
    responses=problems(400, 404, 409, 413, 422, 429, 503),
)


@router.post("/check", operation_id="checkConfigurations", response_model=CheckResponse)
async def check(
    scene: SceneId,
    request: CheckRequest,
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
) -> Response:
    """Check configurations: limits, and every pair of bodies that collides, with its depth."""
    record = await scenes.get(scene, revision)
    check_request(record, request)
    work = QueryWork[CheckRequest].about(scenes.work(record), request)
    return passed_on(await jobs.call_text(CHECK, work, size=len(request.configurations)))


@router.post("/fk", operation_id="computeForwardKinematics", response_model=FkResponse)
async def fk(
    scene: SceneId,
    request: FkRequest,
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
) -> Response:
    """Compute where frames are in given configurations."""
    record = await scenes.get(scene, revision)
    check_request(record, request)
    work = QueryWork[FkRequest].about(scenes.work(record), request)
    return passed_on(await jobs.call_text(FK, work, size=len(request.configurations)))


@router.post("/ik", operation_id="solveInverseKinematics", response_model=IkResponse)
async def ik(
    scene: SceneId,
    request: IkRequest,
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
) -> Response:
    """Find all distinct configurations that reach a goal, or say why there is none."""
    record = await scenes.get(scene, revision)
    check_request(record, request)
    work = QueryWork[IkRequest].about(scenes.work(record), request)
    return passed_on(await jobs.call_text(IK, work))


@router.post("/line", operation_id="traceLine", response_model=LineResponse)
async def line(
    scene: SceneId,
    request: LineRequest,
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
) -> Response:
    """Move a tool in a straight line as far as it goes, and say exactly why it stops."""
    record = await scenes.get(scene, revision)
    check_request(record, request)
    work = QueryWork[LineRequest].about(scenes.work(record), request)
    return passed_on(await jobs.call_text(LINE, work))
