"""/v1/planners: OMPL's planners."""

from fastapi import APIRouter

from service.api.responses import problems
from service.api.strict_route import StrictRoute
from service.catalog.planner_models import PlannerList
from service.dependencies import DeskDep

router = APIRouter(route_class=StrictRoute, prefix="/v1/planners", tags=["planners"])


@router.get(
    "", operation_id="listPlanners", response_model=PlannerList, responses=problems(422, 429, 503)
)
async def list_planners(desk: DeskDep) -> object:
    """List the planners that a plan may name, with their parameters."""
    return {"items": await desk.planners()}
