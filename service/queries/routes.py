"""/v1/scenes/{id}/check, fk, ik, line: questions to a scene."""

from fastapi import APIRouter, Response

from service.api.params import Revision, SceneId
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.queries.models.check import CheckRequest, CheckResponse
from service.queries.models.kinematics import FkRequest, FkResponse, IkRequest, IkResponse
from service.queries.models.line import LineRequest, LineResponse
from service.queries.tasks import CHECK, FK, IK, LINE
from service.scenes.dependencies import WITH_REVISION, SceneCallsDep
from service.scenes.validation import check_request

router = APIRouter(
    route_class=StrictRoute,
    prefix="/v1/scenes/{scene}",
    tags=["queries"],
    responses={200: WITH_REVISION, **problems(400, 404, 409, 413, 422, 429, 503)},
)


@router.post("/check", operation_id="checkConfigurations", response_model=CheckResponse)
async def check(
    scene: SceneId, request: CheckRequest, calls: SceneCallsDep, revision: Revision = None
) -> Response:
    """Check configurations: limits, and every pair of bodies that collides, with its depth."""
    record = await calls.scenes.get(scene, revision)
    check_request(record, request)
    return await calls.answer(CHECK, record, request, len(request.configurations))


@router.post("/fk", operation_id="computeForwardKinematics", response_model=FkResponse)
async def fk(
    scene: SceneId, request: FkRequest, calls: SceneCallsDep, revision: Revision = None
) -> Response:
    """Compute where frames are in given configurations."""
    record = await calls.scenes.get(scene, revision)
    check_request(record, request)
    return await calls.answer(FK, record, request, len(request.configurations))


@router.post("/ik", operation_id="solveInverseKinematics", response_model=IkResponse)
async def ik(
    scene: SceneId, request: IkRequest, calls: SceneCallsDep, revision: Revision = None
) -> Response:
    """Find all distinct configurations that reach a goal, or say why there is none."""
    record = await calls.scenes.get(scene, revision)
    check_request(record, request)
    return await calls.answer(IK, record, request)


@router.post("/line", operation_id="traceLine", response_model=LineResponse)
async def line(
    scene: SceneId, request: LineRequest, calls: SceneCallsDep, revision: Revision = None
) -> Response:
    """Move a tool in a straight line as far as it goes, and say exactly why it stops."""
    record = await calls.scenes.get(scene, revision)
    check_request(record, request)
    return await calls.answer(LINE, record, request)
