"""Planning, as a job."""

import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from planning import Deadline, PlanningProblem, World, plan
from planning.api.sample_motion import sample_plan
from planning.domain.curves.sampling import Sampling
from planning.domain.report.motion_plan import MotionPlan, Progress
from planning.errors import PlanningFailure
from service.jobs.context import TaskContext
from service.plans.cores import own_core
from service.plans.models.goal_values import problem_value
from service.plans.models.request import PlanRequest
from service.plans.models.result_conversion import plan_wire
from service.plans.models.sampling import require_few
from service.plans.models.trajectory import Trajectory
from service.plans.models.trajectory_conversion import polynomial_wire
from service.plans.progress import StageLog
from service.plans.roadmaps import shelf_in
from service.regions.worker import read_regions
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world

# A plan minds its deadline by itself; a process that is this much too late hangs [s].
_PATIENCE = 5.0
# To prove the samples that are delivered: at most, and at least, however late the plan is [s].
PROVING, _LEAST_PROVING = 5.0, 0.25
# To write down what was found [s].
_WRITING = 10.0


def plan_motion(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return a plan's `result`, exact `polynomial`, `timings` [s], `digest`, `cut_short`, `graph`.

    The allowed time begins once the scene is loaded; soon after it the process is ended.

    Raises:
        WayproofError: There is no motion; the error says why.
    """
    request = PlanRequest.model_validate(payload["request"])
    log = StageLog(channel)
    log(Progress("load", 0.0))
    begun = time.monotonic()
    with (
        borrow_world(SceneWork.model_validate(payload)) as world,
        own_core(payload.get("cores")) as pool,
    ):
        loaded = time.monotonic() - begun
        allowed = request.search.allowed_planning_time
        deadline = Deadline.after(allowed, time.monotonic, channel.is_canceled)
        mind(channel, allowed)
        problem = problem_value(request)
        if "regions" in payload:
            problem = replace(problem, regions=read_regions(payload["regions"]))
        shelf = None if request.search.roadmap is None else shelf_in(payload["roadmaps"])
        with loaded_in(loaded):
            found = plan(
                problem, world, deadline=deadline, on_progress=log, roadmaps=shelf, pool=pool
            )
        log(Progress("samples", 0.97))
        mind_delivery(channel)
        return delivered(found, problem, world, request.retime.sampling, deadline, loaded)


def mind(channel: TaskContext, allowed: float) -> None:
    """Have the process ended soon after the allowed time [s], which begins now."""
    channel.allow(allowed + _PATIENCE)


def mind_delivery(channel: TaskContext) -> None:
    """Have the process ended if it does not deliver soon what it has found."""
    channel.allow(PROVING + _WRITING)


@contextmanager
def loaded_in(seconds: float) -> Generator[None]:
    """Have failures from inside tell how long it took to load the scene [s]."""
    try:
        yield
    except PlanningFailure as failure:
        failure.timings = {"load": seconds, **failure.timings}
        raise


def delivered(
    found: MotionPlan,
    problem: PlanningProblem,
    world: World,
    sampling: Sampling,
    deadline: Deadline,
    loaded: float,
) -> dict[str, Any]:
    """Return what a job keeps of a plan.

    Args:
        found: The plan.
        problem: What it solves.
        world: The scene.
        sampling: At which instants to sample it.
        deadline: Of the plan: what is left of it is for the proof of the samples, a little at
            least. What is not proven by then is told as not proven.
        loaded: How long it took to load the scene [s].
    """
    require_few(found.trajectory, sampling)
    began, cuts = deadline.clock(), set[str]()
    until = min(max(deadline.expires_at, began + _LEAST_PROVING), began + PROVING)
    # Who wants the best there is from a cancel wants it delivered as well.
    wants_best = problem.search.on_cancel == "best"
    proving = replace(deadline.uncancelable if wants_best else deadline, expires_at=until)
    proven = sample_plan(
        world,
        problem,
        found.trajectory,
        found.parts,
        sampling,
        deadline=proving.with_on_expiry(lambda: cuts.add("samples")),
        clearance=found.certificate.proven_clearance,
    )
    samples = deadline.clock() - began
    trajectory = Trajectory.from_samples(proven.samples, proven.interpolations)
    result = plan_wire(found, trajectory, [*cuts])
    return {
        "result": result,
        "polynomial": polynomial_wire(found.trajectory),
        "timings": {"load": loaded, **found.timings, "samples": samples},
        "digest": result["digest"],
        "cut_short": result["cut_short"],
        "graph": None if found.graph is None else found.graph.as_json,
    }
