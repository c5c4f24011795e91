"""/v1/scenes/{id}/view.html: a scene to look at."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from service.api.dependencies import JobsDep
from service.api.params import Revision, SceneId
from service.api.responses import HTML_PAGE, problems
from service.api.routing.strict_route import StrictRoute
from service.queries.tasks import VIEW
from service.scenes.dependencies import ScenesDep

router = APIRouter(route_class=StrictRoute, prefix="/v1/scenes/{scene}/view.html", tags=["scenes"])


@router.get(
    "",
    operation_id="getSceneView",
    response_class=HTMLResponse,
    responses={200: HTML_PAGE, **problems(404, 409, 422, 429, 503)},
)
async def get_scene_view(
    scene: SceneId, scenes: ScenesDep, jobs: JobsDep, revision: Revision = None
) -> HTMLResponse:
    """Show a scene in 3-D, the robots where they are: a self-contained page."""
    page = await jobs.call(VIEW, scenes.work(await scenes.get(scene, revision)))
    return HTMLResponse(page.html)
