"""/v1/models: robots there are."""

from typing import Annotated

from fastapi import APIRouter, Path

from planning.errors import UnknownName
from service.api.responses import problems
from service.api.strict_route import StrictRoute
from service.dependencies import DeskDep
from service.errors import UnknownResource
from service.scenes.summary_models import Model, ModelList

router = APIRouter(route_class=StrictRoute, prefix="/v1/models", tags=["models"])


@router.get(
    "", operation_id="listModels", response_model=ModelList, responses=problems(422, 429, 503)
)
async def list_models(desk: DeskDep) -> object:
    """List the robots that scenes may name."""
    return await desk.ask("service.catalog.worker:name_models", desk.common)


@router.get(
    "/{name}",
    operation_id="getModel",
    response_model=Model,
    responses=problems(404, 422, 429, 503),
)
async def get_model(
    desk: DeskDep, name: Annotated[str, Path(max_length=256, description="Name of a robot")]
) -> object:
    """Show a robot: its groups, joints, limits, tool frames and configurations."""
    try:
        return await desk.ask("service.catalog.worker:show_model", {**desk.common, "name": name})
    except UnknownName as fault:
        raise UnknownResource(fault.detail, fault.evidence) from fault
