"""/v1/planners: OMPL's planners."""

from fastapi import APIRouter

from service.dependencies import JobsDep
from service.routes.answers import problems
from service.schemas.planner import PlannerList
from service.strict_route import StrictRoute

router = APIRouter(route_class=StrictRoute, prefix="/v1/planners", tags=["planners"])


@router.get(
    "", operation_id="listPlanners", response_model=PlannerList, responses=problems(422, 429, 503)
)
async def list_planners(desk: JobsDep) -> object:
    """List the planners that a plan may name, with their parameters."""
    return {"items": await desk.planners()}
