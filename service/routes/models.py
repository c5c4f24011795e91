"""/v1/models: robots there are."""

from typing import Annotated

from fastapi import APIRouter, Path

from planning.errors import UnknownName
from service.dependencies import JobsDep
from service.errors import UnknownResource
from service.routes.answers import problems
from service.schemas.summary import ModelList, ModelWire
from service.strict_route import StrictRoute

router = APIRouter(route_class=StrictRoute, prefix="/v1/models", tags=["models"])


@router.get(
    "", operation_id="listModels", response_model=ModelList, responses=problems(422, 429, 503)
)
async def list_models(desk: JobsDep) -> object:
    """List the robots that scenes may name."""
    return await desk.ask("service.tasks.models:name_models", desk.common)


@router.get(
    "/{name}",
    operation_id="getModel",
    response_model=ModelWire,
    responses=problems(404, 422, 429, 503),
)
async def get_model(
    desk: JobsDep, name: Annotated[str, Path(max_length=256, description="Name of a robot")]
) -> object:
    """Show a robot: its groups, joints, limits, tool frames and configurations."""
    try:
        return await desk.ask("service.tasks.models:show_model", {**desk.common, "name": name})
    except UnknownName as fault:
        raise UnknownResource(fault.detail, fault.evidence) from fault
