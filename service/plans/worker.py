"""Planning and reversing a motion, as jobs."""

import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

from planning import Deadline, PlanningProblem, RoadmapCache, World, plan, reverse_plan
from planning.api.sample_motion import sample_plan
from planning.domain.curves.path import JointPath
from planning.domain.curves.sampling import Sampling
from planning.domain.report.motion_plan import MotionPlan, Progress
from planning.errors import PlanningFailure
from planning.parallel.core_leases import CoreLeases
from planning.parallel.fork_pool import ForkPool
from service.api.arrays import matrix
from service.jobs.context import TaskContext
from service.jobs.host_folder import artifact_path, host_folder
from service.jobs.worker.progress import ProgressReporter
from service.plans.models.result import PlanResult
from service.plans.models.sampling import require_few
from service.plans.models.search_reports import PlannerGraph
from service.plans.models.trajectory import Polynomial, Trajectory
from service.plans.tasks import PLAN, REVERSE, Cores, PlanOutcome, PlanWork, ReverseWork
from service.regions.worker import read_regions
from service.scenes.world_cache import borrow_world

# A plan observes its deadline itself; a process that is this much too late hangs [s]. On two
# processors with ten times as much to do, plans were late by a quarter of a second at most.
_PATIENCE = 1.0
# To prove the samples that are delivered: at most, and at least, however late the plan is [s].
PROVING, _LEAST_PROVING = 5.0, 0.25
# To write the outcome down [s].
_WRITING = 10.0


@PLAN.runs
def plan_motion(work: PlanWork, context: TaskContext) -> PlanOutcome:
    """Plan a motion.

    The allowed time begins once the scene is loaded; soon after it the process is ended.

    Raises:
        WayproofError: There is no motion; the error says why.
    """
    request, report = work.request, ProgressReporter(context)
    report(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(work) as world, reserve_core(work.cores) as pool:
        loaded = time.monotonic() - begun
        deadline = _enforce_deadline(context, report, request.search.allowed_planning_time)
        problem = request.to_domain()
        if work.regions is not None:
            problem = replace(
                problem, regions=read_regions(artifact_path(host_folder(), work.regions))
            )
        roadmaps = (
            None if request.search.roadmap is None else roadmaps_in(host_folder() / "roadmaps")
        )
        with _timed_failures(loaded, report):
            found = plan(
                problem, world, deadline=deadline, on_progress=report, roadmaps=roadmaps, pool=pool
            )
        report(Progress("samples", 0.97))
        _enforce_delivery(context)
        return _plan_outcome(found, problem, world, request.retime.sampling, deadline, loaded)


@REVERSE.runs
def reverse_motion(work: ReverseWork, context: TaskContext) -> PlanOutcome:
    """Reverse the motion of a plan, and prove it anew.

    Raises:
        WayproofError: It cannot be proven; the error says why.
    """
    request, problem = work.request, (work.origin or work.request).to_domain()
    report = ProgressReporter(context)
    report(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(work) as world:
        loaded = time.monotonic() - begun
        report(Progress("certify", 0.5, "certifying the motion backwards", until=0.95))
        deadline = _enforce_deadline(context, report, request.search.allowed_planning_time)
        with _timed_failures(loaded, report):
            found = reverse_plan(
                world,
                problem,
                JointPath(world.group(problem.group), matrix(work.motion.path)),
                work.motion.polynomial.to_domain(),
                work.motion.parts,
                deadline,
            )
        report(Progress("samples", 0.97))
        _enforce_delivery(context)
        return _plan_outcome(found, problem, world, request.retime.sampling, deadline, loaded)


@contextmanager
def reserve_core(cores: Cores | None) -> Generator[ForkPool | None]:
    """Take a core for a plan, so that others see it busy, and yield the pool of the idle ones.

    A plan runs whether there is a core for it or not.
    """
    if cores is None:
        yield None
        return
    shared = CoreLeases(host_folder() / "cores", cores.count)
    with shared.lease(1):
        yield ForkPool(shared)


@cache
def roadmaps_in(folder: Path) -> RoadmapCache:
    """Return this process's cache over a folder that all processes of a host share."""
    return RoadmapCache(folder=folder)


def _enforce_deadline(context: TaskContext, report: ProgressReporter, allowed: float) -> Deadline:
    """Return the deadline of a plan whose time [s] begins now; the process ends soon after it."""
    deadline = Deadline.after(allowed, time.monotonic, report.is_canceled)
    report.set_deadline(deadline.expires_at)
    context.allow(allowed, _PATIENCE)
    return deadline


def _enforce_delivery(context: TaskContext) -> None:
    """Have the process ended if it does not deliver soon."""
    context.allow(PROVING + _WRITING)


@contextmanager
def _timed_failures(loaded: float, report: ProgressReporter) -> Generator[None]:
    """Have failures from inside say how long it took to load the scene [s], and how far it came."""
    try:
        yield
    except PlanningFailure as failure:
        report.tell_time()
        failure.timings = {"load": loaded, **failure.timings}
        raise


def _plan_outcome(
    found: MotionPlan,
    problem: PlanningProblem,
    world: World,
    sampling: Sampling,
    deadline: Deadline,
    loaded: float,
) -> PlanOutcome:
    """Return what a job keeps of a plan.

    Args:
        found: The plan.
        problem: What it solves.
        world: The scene.
        sampling: At which instants to sample it.
        deadline: Of the plan: what is left of it is for the proof of the samples, a little at
            least. What is not proven by then is delivered as not proven.
        loaded: How long it took to load the scene [s].
    """
    require_few(found.trajectory, sampling)
    began, cuts = deadline.clock(), set[str]()
    until = min(max(deadline.expires_at, began + _LEAST_PROVING), began + PROVING)
    # With `on_cancel: best` a cancel ends the search, and what it found is delivered all the same.
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
    result = PlanResult.from_domain(found, trajectory, cuts)
    return PlanOutcome(
        result=result,
        polynomial=Polynomial.from_domain(found.trajectory),
        timings={"load": loaded, **found.timings, "samples": samples},
        digest=result.digest,
        cut_short=result.cut_short or [],
        graph=None if found.graph is None else PlannerGraph.model_validate(found.graph),
    )
