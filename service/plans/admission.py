"""Admission: what a plan request must satisfy before it becomes a job."""

from typing import Any

from anyio import to_thread

from planning.domain.planner.unavailable_planners import unknown_planner
from planning.domain.robot.steering_request import resolve_steering, validate_forward_planners
from planning.errors import UnknownName
from service.convert.goals import steering_value
from service.convert.trajectories import require_one_sampling
from service.job_spec import spec_of
from service.jobs.job import IdempotencyKey, Job
from service.regions.choice import chosen_regions, regions_file
from service.regions.fitness import asks_for_regions, own_cars, require_fit
from service.scene_jobs import SceneJobs
from service.scenes.preflight import (
    Group,
    require_constraints,
    require_count,
    require_goal,
    require_group,
    require_joints,
)
from service.scenes.records import SceneRecord
from service.scenes.shelf import SceneShelf
from service.scenes.timing import require_motion_limits
from service.schemas.plan import PlanRequest
from service.schemas.search import CarWire, SearchWire

TASK = "service.tasks.plan:plan_motion"

# To load the scene as well [s]; once that is done the task itself says by when it has to end.
SLACK = 15.0


async def submit_plan(
    request: PlanRequest, key: str | None, scenes: SceneShelf, desk: SceneJobs
) -> Job:
    """Queue a plan.

    Args:
        request: What to plan.
        key: Idempotency key, or None.
        scenes: Where its scene is.
        desk: Where jobs are queued.

    Raises:
        UnknownResource: There is no such scene or revision.
        UnknownName: The scene has no such group, joint, frame or configuration, or nobody has
            the planner.
        ProblemInvalid: A base cannot drive as is asked, or a planner cannot search for that, or
            regions are named and no planner needs them, or samples are asked for twice.
        WrongCount: A list of positions does not fit the group.
        IdempotencyConflict: The key was used for another request.
        NoRegions: The planner GCS is asked for, and no regions fit.
        QueueFull: The queue is full.
    """
    record = await scenes.get(request.scene, request.revision)
    group = require_group(record, request.group)
    if request.start is not None:
        require_count(group, request.start, "start")
    require_goal(record, group, request.goal)
    require_constraints(record, group, request.path_constraints)
    require_motion_limits(record, group, request.retime)
    require_one_sampling(request.retime.sample_period, request.retime.num_points)
    require_joints(group, request.ik.joint_weights)
    require_planner(await desk.planners(), request.search)
    require_search_names(group, request.search)
    require_cars(group, request.search)
    regions = await chosen_regions(request, record, desk)
    payload = {
        **await desk.scene_payload(record),
        "request": _settled(request, record, regions),
        "revision": record.revision,
        "roadmaps": desk.roadmaps,
        "cores": desk.cores,
    }
    if regions is not None:
        payload["regions"] = await to_thread.run_sync(regions_file, desk.regions_folder, regions)
    if request.search.on_cancel == "best":
        payload["cancel_grace"] = desk.best_grace
    allowed = request.search.allowed_planning_time + SLACK
    named = IdempotencyKey(key, request.model_dump(mode="json"))
    return await desk.submit(
        spec_of("plan", TASK, payload, scene=record, key=named, allowed=allowed)
    )


def _settled(request: PlanRequest, record: SceneRecord, regions: Job | None) -> dict[str, Any]:
    """Return the request with what time would decide: asked again, it gives the same bytes."""
    settled = request.model_dump(mode="json")
    settled["revision"] = record.revision
    if regions is not None:
        settled["search"]["regions"] = regions.id
    return settled


def require_planner(planners: list[dict[str, Any]], search: SearchWire) -> None:
    """Go on only if there are such planners, and one of them has such parameters.

    Raises:
        UnknownName: There are not.
    """
    by_name = {planner["name"]: planner for planner in planners}
    names = [search.planner] if isinstance(search.planner, str) else search.planner
    known: set[str] = set()
    for name in names:
        if name not in by_name:
            raise unknown_planner(name, by_name)
        known |= {parameter["name"] for parameter in by_name[name]["parameters"]}
    for parameter in search.parameters:
        if parameter not in known:
            raise UnknownName.among("parameter", parameter, known)


def require_search_names(group: Group, search: SearchWire) -> None:
    """Go on only if the group has the joints and coordinates that the search names.

    Raises:
        UnknownName: It has not.
    """
    joints = {joint["name"]: joint["type"] for joint in group["joints"]}
    bodies = [name for name, kind in joints.items() if kind in {"planar", "floating"}]
    named = (
        ("joint or block", search.weights, [*joints, *group["limits"]["blocks"]]),
        ("position", search.bounds, group["position_names"]),
        ("planar or floating joint", search.spaces, bodies),
    )
    for kind, names, known in named:
        for name in names:
            if name not in known:
                raise UnknownName.among(kind, name, dict.fromkeys(known))


def require_cars(group: Group, search: SearchWire) -> None:
    """Go on only if the group's bases can drive as is asked, and the planners can search for that.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: The robot cannot drive so, or a planner checks motions backwards, or the
            group can have no regions and the planner GCS is asked for.
    """
    asked = {
        name: steering_value(space)
        for name, space in search.spaces.items()
        if isinstance(space, CarWire)
    }
    planar = [joint["name"] for joint in group["joints"] if joint["type"] == "planar"]
    names = [search.planner] if isinstance(search.planner, str) else search.planner
    cars = resolve_steering(own_cars(group), asked, planar)
    if asks_for_regions(search):
        require_fit(group, cars, "search.planner")
    validate_forward_planners(names, cars)
