"""Admission: what a plan request must satisfy before it becomes a job."""

from typing import Any

from planning.errors import UnknownName
from service.desk import Desk, spec_of
from service.jobs.records import Job
from service.scenes.preflight import (
    require_constraints,
    require_count,
    require_goal,
    require_group,
)
from service.scenes.shelf import SceneShelf
from service.schemas.plan import PlanRequest, SearchWire

TASK = "service.tasks.plan:plan_motion"

# A plan minds its deadline by itself; a process that is this much too late hangs [s].
_SLACK = 15.0


async def submit_plan(request: PlanRequest, key: str | None, scenes: SceneShelf, desk: Desk) -> Job:
    """Queue a plan.

    Args:
        request: What to plan.
        key: Idempotency key, or None.
        scenes: Where its scene is.
        desk: Where jobs are queued.

    Raises:
        UnknownResource: There is no such scene or revision.
        UnknownName: The scene has no such group, frame or configuration; nobody has the planner.
        WrongCount: A list of positions does not fit the group.
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue is full.
    """
    record = await scenes.get(request.scene, request.revision)
    group = require_group(record, request.group)
    if request.start is not None:
        require_count(group, request.start, "start")
    require_goal(record, group, request.goal)
    require_constraints(record, group, request.path_constraints)
    require_planner(await desk.planners(), request.search)
    payload = {
        **await desk.scene_payload(record),
        "request": request.model_dump(mode="json"),
        "revision": record.revision,
    }
    allowed = request.search.allowed_planning_time + _SLACK
    return desk.submit(spec_of("plan", TASK, payload, scene=record, key=key, allowed=allowed))


def require_planner(planners: list[dict[str, Any]], search: SearchWire) -> None:
    """Go on only if there is such a planner with such parameters.

    Raises:
        UnknownName: There is not.
    """
    by_name = {planner["name"]: planner for planner in planners}
    if search.planner not in by_name:
        raise UnknownName.among("planner", search.planner, by_name)
    known = [parameter["name"] for parameter in by_name[search.planner]["parameters"]]
    for name in search.parameters:
        if name not in known:
            raise UnknownName.among("parameter", name, known)
