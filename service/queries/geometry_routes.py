"""/v1/scenes/{id}/geometry: what a scene looks like, for whatever draws it."""

from base64 import b64decode
from typing import Annotated

from fastapi import APIRouter, Path, Response

from service.api.dependencies import JobsDep
from service.api.params import Revision, SceneId
from service.api.responses import passed_on, problems
from service.api.routing.strict_route import StrictRoute
from service.errors import UnknownResource
from service.queries.models.geometry import Digest, Geometry, MeshRequest
from service.queries.tasks import GEOMETRY, MESH
from service.scenes.dependencies import ScenesDep
from service.scenes.etags import ETAG_HEADER, IfNoneMatch, etag_of, is_known
from service.scenes.tasks import RequestWork

router = APIRouter(route_class=StrictRoute, prefix="/v1/scenes/{scene}/geometry", tags=["scenes"])

_UNCHANGED = {"description": "`If-None-Match` names this revision", "headers": ETAG_HEADER}
_BINARY = {"type": "string", "format": "binary", "description": "glTF 2.0, binary"}
_MESH = {200: {"content": {"model/gltf-binary": {"schema": _BINARY}}}}
# By its digest, a mesh never changes.
_LASTING = {"Cache-Control": "private, max-age=31536000, immutable"}


class _Glb(Response):
    media_type = "model/gltf-binary"


@router.get(
    "",
    operation_id="getSceneGeometry",
    response_model=Geometry,
    responses={
        200: {"headers": ETAG_HEADER},
        304: _UNCHANGED,
        **problems(404, 409, 422, 429, 503),
    },
)
async def get_geometry(
    scene: SceneId,
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
    known: IfNoneMatch = None,
) -> Response:
    """Show what the bodies of a scene look like: shapes, colours, and poses of what is fixed."""
    record = await scenes.get(scene, revision)
    headers = {"ETag": etag_of(record)}
    if is_known(record, known):
        return Response(status_code=304, headers=headers)
    return passed_on(await jobs.call_text(GEOMETRY, scenes.work(record)), headers=headers)


@router.get(
    "/{sha256}.glb",
    operation_id="getSceneMesh",
    response_class=_Glb,
    responses={**_MESH, **problems(404, 409, 422, 429, 503)},
)
async def get_mesh(
    scene: SceneId,
    sha256: Annotated[Digest, Path(description="sha256 of the mesh, as the geometry names it")],
    scenes: ScenesDep,
    jobs: JobsDep,
    revision: Revision = None,
) -> Response:
    """Return a mesh that the geometry of a scene names."""
    record = await scenes.get(scene, revision)
    work = RequestWork[MeshRequest].about(scenes.work(record), MeshRequest(sha256=sha256))
    found = await jobs.call(MESH, work)
    if found.glb is None:
        raise UnknownResource.of("mesh", sha256)
    return _Glb(b64decode(found.glb), headers=_LASTING)
