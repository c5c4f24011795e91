"""/v1/models and /v1/planners: what there is to choose from."""

from typing import Annotated

from fastapi import APIRouter, Path, Response

from planning.errors import UnknownName
from service.api.dependencies import JobsDep
from service.api.responses import passed_on, problems
from service.api.routing.strict_route import StrictRoute
from service.catalog.models import ModelList, PlannerList
from service.catalog.planners import known_planners
from service.catalog.tasks import LIST_MODELS, SHOW_MODEL, ModelWork
from service.errors import UnknownResource
from service.scenes.dependencies import ScenesDep
from service.scenes.models.summary import Model
from service.scenes.tasks import LibraryWork

router = APIRouter(route_class=StrictRoute, prefix="/v1")


@router.get(
    "/models",
    operation_id="listModels",
    response_model=ModelList,
    responses=problems(422, 429, 503),
    tags=["models"],
)
async def list_models(jobs: JobsDep, scenes: ScenesDep) -> Response:
    """List the robots that scenes may name."""
    return passed_on(await jobs.call_text(LIST_MODELS, LibraryWork(library=scenes.library)))


@router.get(
    "/models/{name}",
    operation_id="getModel",
    response_model=Model,
    responses=problems(404, 422, 429, 503),
    tags=["models"],
)
async def get_model(
    jobs: JobsDep,
    scenes: ScenesDep,
    name: Annotated[str, Path(max_length=256, description="Name of a robot")],
) -> Response:
    """Show a robot: its groups, joints, limits, tool frames and configurations."""
    try:
        work = ModelWork(library=scenes.library, name=name)
        return passed_on(await jobs.call_text(SHOW_MODEL, work))
    except UnknownName as fault:
        raise UnknownResource(fault.detail, fault.evidence) from fault


@router.get(
    "/planners",
    operation_id="listPlanners",
    responses=problems(422, 429, 503),
    tags=["planners"],
)
async def list_planners(jobs: JobsDep) -> PlannerList:
    """List the planners that a plan may name, with their parameters."""
    return PlannerList(items=await known_planners(jobs))
