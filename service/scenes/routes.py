"""/v1/scenes: post, list, show, edit, forget."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import HTMLResponse

from planning.errors import UnknownName
from service.api.paging import Cursor, Limit, before, cursor_of
from service.api.params import Revision, SceneId
from service.api.responses import passed_on, problems
from service.api.strict_route import StrictRoute
from service.dependencies import JobsDep, ScenesDep
from service.errors import UnknownInScene
from service.executions.replay import executed_motions
from service.plans.tasks import REPLAY_MOTIONS, ReplayWork
from service.scenes.edits import apply_edits
from service.scenes.models.edits import SceneEdit
from service.scenes.models.scene import Scene, SceneBrief, ScenePage
from service.scenes.request_body import REQUEST_BODY, read_scene_body
from service.scenes.resource import scene_text
from service.scenes.tasks import LOAD_SCENE, LoadWork

router = APIRouter(route_class=StrictRoute, prefix="/v1/scenes", tags=["scenes"])

# Each may need a world of its own in memory.
_MOST_MOTIONS = 32

type LastMotions = Annotated[
    int, Query(ge=1, le=_MOST_MOTIONS, description="How many motions, counted from the last one")
]
_HTML = {"schema": {"type": "string", "description": "A page that needs nothing else"}}


@router.post(
    "",
    operation_id="createScene",
    status_code=201,
    response_model=Scene,
    response_model_exclude_none=True,
    responses=problems(400, 413, 415, 422, 429, 503),
    openapi_extra={"requestBody": REQUEST_BODY},
)
async def create_scene(request: Request, scenes: ScenesDep, desk: JobsDep) -> Response:
    """Post a scene as JSON or YAML; it is loaded at once, and its faults are named by line."""
    text, media = await read_scene_body(request)
    work = LoadWork(library=desk.library.library, text=text, media=media)
    try:
        loaded = await desk.load(LOAD_SCENE, work, size=len(text))
    except UnknownName as fault:
        raise UnknownInScene(fault.detail, fault.evidence) from fault
    record = await scenes.add(loaded)
    location = {"location": f"/v1/scenes/{record.id}"}
    return passed_on(scene_text(record), 201, location)


@router.get("", operation_id="listScenes", responses=problems(422))
async def list_scenes(scenes: ScenesDep, limit: Limit = 50, cursor: Cursor = None) -> ScenePage:
    """List scenes, newest first."""
    records = await scenes.page(limit + 1, before(cursor))
    following = cursor_of(records[limit - 1].serial) if len(records) > limit else None
    items = [SceneBrief.model_validate(record) for record in records[:limit]]
    return ScenePage(items=items, next=following)


@router.get(
    "/{scene}",
    operation_id="getScene",
    response_model=Scene,
    response_model_exclude_none=True,
    responses=problems(404, 422),
)
async def get_scene(scene: SceneId, scenes: ScenesDep, revision: Revision = None) -> Response:
    """Show a scene, by default its latest revision: document, groups, frames and bodies."""
    return passed_on(scene_text(await scenes.get(scene, revision)))


@router.get(
    "/{scene}/replay.html",
    operation_id="getSceneReplay",
    response_class=HTMLResponse,
    responses={200: {"content": {"text/html": _HTML}}, **problems(404, 409, 422, 429, 503)},
)
async def get_scene_replay(
    scene: SceneId, scenes: ScenesDep, desk: JobsDep, last: LastMotions = _MOST_MOTIONS
) -> HTMLResponse:
    """Replay in 3-D what executions moved in a scene, one motion after the other."""
    record = await scenes.stored(scene)
    motions = await executed_motions(desk, record.id, last)
    page = await desk.call(REPLAY_MOTIONS, ReplayWork(motions=motions))
    return HTMLResponse(page.html)


@router.patch(
    "/{scene}",
    operation_id="editScene",
    response_model=Scene,
    response_model_exclude_none=True,
    responses=problems(400, 404, 409, 413, 422, 429, 503),
)
async def edit_scene(
    scene: SceneId, request: SceneEdit, scenes: ScenesDep, desk: JobsDep
) -> Response:
    """Edit a scene: its next revision, which plans use from now on; older ones stay."""
    return passed_on(scene_text(await apply_edits(scene, request, scenes, desk)))


@router.delete(
    "/{scene}", operation_id="deleteScene", status_code=204, responses=problems(404, 422)
)
async def delete_scene(scene: SceneId, scenes: ScenesDep) -> None:
    """Forget a scene; plans that were made in it stay."""
    await scenes.delete(scene)
