"""Planning, as a job."""

import time
from dataclasses import replace
from typing import Any

from planning import Deadline, PlanningProblem, World, plan, sample_plan
from planning.domain.plan import MotionPlan, Progress
from service.convert.goals import problem_value
from service.convert.plans import plan_wire
from service.convert.trajectories import polynomial_wire, require_few, sampled_wire
from service.schemas.plan import PlanRequest
from service.tasks.channel import Channel
from service.tasks.cores import own_core
from service.tasks.regions import read_regions
from service.tasks.roadmaps import shelf_in
from service.tasks.stage_log import StageLog
from service.tasks.worlds import borrow_world

# A plan minds its deadline by itself; a process that is this much too late hangs [s].
_PATIENCE = 5.0
# To prove the samples that are delivered [s].
PROVING = 5.0
# To write down what was found [s].
_WRITING = 10.0


def plan_motion(payload: dict[str, Any], channel: Channel) -> dict[str, Any]:
    """Return the `result` of a plan, its exact `polynomial`, `timings` [s], `digest` and `graph`.

    The allowed time begins once the scene is loaded; soon after it the process is ended.

    Raises:
        WayproofError: There is no motion; the error says why.
    """
    request = PlanRequest.model_validate(payload["request"])
    log = StageLog(channel)
    log(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(payload) as world, own_core(payload.get("cores")) as pool:
        loaded = time.monotonic() - begun
        allowed = request.search.allowed_planning_time
        deadline = Deadline.after(allowed, time.monotonic, channel.is_canceled)
        mind(channel, allowed)
        problem = problem_value(request)
        if "regions" in payload:
            problem = replace(problem, regions=read_regions(payload["regions"]))
        found = plan(
            problem,
            world,
            deadline=deadline,
            on_progress=log,
            roadmaps=None if request.search.roadmap is None else shelf_in(payload["roadmaps"]),
            pool=pool,
        )
        return delivered(found, problem, world, request, loaded, channel)


def mind(channel: Channel, allowed: float) -> None:
    """Have the process ended soon after the allowed time [s], which begins now."""
    channel.allow(allowed + _PATIENCE)


def delivered(
    found: MotionPlan,
    problem: PlanningProblem,
    world: World,
    request: PlanRequest,
    loaded: float,
    channel: Channel,
) -> dict[str, Any]:
    """Return what a job keeps of a plan of a problem; loading the scene took `loaded` [s]."""
    channel.allow(PROVING + _WRITING)
    sampling = request.retime.sampling
    require_few(found.trajectory, sampling)
    begun = time.monotonic()
    proven = sample_plan(
        world,
        problem,
        found.trajectory,
        found.parts,
        sampling,
        deadline=Deadline.after(PROVING, time.monotonic, channel.is_canceled),
        clearance=found.certificate.proven_clearance,
    )
    timings = {"load": loaded, **found.timings, "samples": time.monotonic() - begun}
    result = plan_wire(found, sampled_wire(proven.samples, proven.interpolations))
    return {
        "result": result,
        "polynomial": polynomial_wire(found.trajectory),
        "timings": timings,
        "digest": result["digest"],
        "graph": None if found.graph is None else found.graph.plain,
    }
