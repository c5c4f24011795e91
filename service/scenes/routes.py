"""/v1/scenes: post, list, show, edit, forget."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.api.dependencies import JobsDep
from service.api.paging import Cursor, Limit, before, cursor_of
from service.api.params import Revision, SceneId
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.api.submission import KeyHeader
from service.errors import RevisionConflict
from service.scenes.dependencies import ScenesDep
from service.scenes.edits import apply_edits
from service.scenes.etags import (
    ETAG_HEADER,
    IfMatch,
    IfNoneMatch,
    check_match,
    etag_of,
    is_known,
)
from service.scenes.models.edits import SceneEdit
from service.scenes.models.scene import EditedScene, Scene, SceneBrief, ScenePage
from service.scenes.request_body import REQUEST_BODY, key_of, read_scene_body
from service.scenes.resource import edited_response, scene_response
from service.scenes.tasks import LOAD_SCENE, LoadWork

router = APIRouter(route_class=StrictRoute, prefix="/v1/scenes", tags=["scenes"])

type SceneName = Annotated[
    str | None,
    Query(max_length=256, description="Name for people of the scenes that are wanted, as it is"),
]

_WITH_ETAG = {"headers": ETAG_HEADER}
_UNCHANGED = {"description": "`If-None-Match` names this revision", "headers": ETAG_HEADER}


@router.post(
    "",
    operation_id="createScene",
    status_code=201,
    response_model=Scene,
    response_model_exclude_none=True,
    responses={201: _WITH_ETAG, **problems(400, 409, 413, 415, 422, 429, 503)},
    openapi_extra={"requestBody": REQUEST_BODY},
)
async def create_scene(
    request: Request, scenes: ScenesDep, jobs: JobsDep, idempotency_key: KeyHeader = None
) -> Response:
    """Post a scene as JSON or YAML; it is loaded at once, and its faults are named by line."""
    text, media = await read_scene_body(request)
    key = None if idempotency_key is None else key_of(idempotency_key, text, media)
    record = None if key is None else await scenes.find_by_key(key)
    if record is None:
        work = LoadWork(library=scenes.library, text=text, media=media)
        loaded = await jobs.call_loading(LOAD_SCENE, work, size=len(text))
        record = await scenes.add(loaded, key)
    return scene_response(record, 201, f"/v1/scenes/{record.id}")


@router.get("", operation_id="listScenes", responses=problems(422))
async def list_scenes(
    scenes: ScenesDep, limit: Limit = 50, cursor: Cursor = None, name: SceneName = None
) -> ScenePage:
    """List scenes, newest first."""
    found, following = await scenes.page(limit, before(cursor), name)
    items = [SceneBrief.model_validate(brief) for brief in found]
    return ScenePage(items=items, next=cursor_of(following))


@router.get(
    "/{scene}",
    operation_id="getScene",
    response_model=Scene,
    response_model_exclude_none=True,
    responses={200: _WITH_ETAG, 304: _UNCHANGED, **problems(404, 422)},
)
async def get_scene(
    scene: SceneId, scenes: ScenesDep, revision: Revision = None, known: IfNoneMatch = None
) -> Response:
    """Show a scene, by default its latest revision: document, groups, frames and bodies."""
    record = await scenes.get(scene, revision)
    if is_known(record, known):
        return Response(status_code=304, headers={"ETag": etag_of(record)})
    return scene_response(record)


@router.patch(
    "/{scene}",
    operation_id="editScene",
    response_model=EditedScene,
    response_model_exclude_none=True,
    responses={200: _WITH_ETAG, **problems(400, 404, 409, 412, 413, 422, 429, 503)},
)
async def edit_scene(
    scene: SceneId,
    request: SceneEdit,
    scenes: ScenesDep,
    jobs: JobsDep,
    if_match: IfMatch = None,
) -> Response:
    """Edit a scene: its next revision, which plans use from now on; older ones stay.

    Motions that are carried out in it are proven again, and those that do not hold stop, if they
    are to.
    """
    record = await apply_edits(scene, request, if_match, scenes, jobs)
    return edited_response(record, await scenes.verdicts(record))


@router.delete(
    "/{scene}",
    operation_id="deleteScene",
    status_code=204,
    response_class=Response,  # which has no content type
    responses=problems(404, 412, 422),
)
async def delete_scene(scene: SceneId, scenes: ScenesDep, if_match: IfMatch = None) -> None:
    """Forget a scene; plans that were made in it stay."""
    if if_match in {None, "*"}:
        await scenes.delete(scene)
        return
    try:
        record = check_match(await scenes.get(scene), if_match)
        await scenes.delete(scene, record.revision)
    except RevisionConflict:  # an edit was quicker
        check_match(await scenes.get(scene), if_match)
        raise
