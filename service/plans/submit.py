"""Plans and reversed plans become jobs, once everything that they name is there."""

from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

from planning.domain.planner.unavailable_planners import unknown_planner
from planning.domain.robot.steering_request import resolve_steering, validate_forward_planners
from planning.errors import UnknownName
from service.api.fingerprint import fingerprint
from service.api.submission import Submission
from service.catalog.models import Planner
from service.catalog.planners import known_planners
from service.jobs.job import IdempotencyKey, Job, JobSpec
from service.jobs.service import JobService
from service.jobs.task import Task
from service.plans.models.goals import JointGoal
from service.plans.models.request import PlanRequest
from service.plans.models.sampling import require_one_sampling
from service.plans.models.search import Search
from service.plans.region_selection import SelectedRegions, keep_regions, select_regions, uses_gcs
from service.plans.resource import motion_of, work_of
from service.plans.tasks import (
    PLAN,
    REVERSE,
    Cores,
    FirstMotion,
    MotionWork,
    PlanOutcome,
    PlanWork,
    ReverseWork,
)
from service.regions.eligibility import check_eligible, own_cars
from service.scenes.job_spec import spec_of
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore
from service.scenes.validation import check_request
from service.settings import Settings

# To load the scene as well [s]; once that is done the task itself says by when it has to end.
SLACK = 15.0


async def submit_plan(request: PlanRequest, submission: Submission, scenes: SceneStore) -> Job:
    """Queue a plan; raises as `plan_spec`, and if it cannot be queued.

    Args:
        request: What to plan.
        submission: How it is submitted.
        scenes: Where its scene is.

    Raises:
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue is full.
    """
    key = IdempotencyKey.of(submission.key, partial(_fingerprint, request))
    return await submission.jobs.submit(await plan_spec(request, key, submission, scenes))


def _fingerprint(request: PlanRequest) -> dict[str, Any]:
    """Return what a request says, as version 0.1 wrote it: keys are older than names of fields."""
    said = fingerprint(request)
    said["ik"]["time_limit"] = said["ik"].pop("allowed_time")
    return said


class PlanTerms(Protocol):
    """With what plans are made: what is known of a `Submission`."""

    @property
    def jobs(self) -> JobService:
        """Where jobs are asked for."""
        ...

    @property
    def settings(self) -> Settings:
        """Of the server."""
        ...


async def plan_spec(
    request: PlanRequest, key: IdempotencyKey, submission: PlanTerms, scenes: SceneStore
) -> JobSpec:
    """Return the job that makes a plan, once all that the request names is there.

    Raises:
        UnknownResource: There is no such scene or revision.
        UnknownName: The scene has no such group, joint, frame or configuration, or there is no
            such planner.
        ProblemInvalid: A base cannot drive as requested, or a planner cannot search for that, or
            regions are named and no planner needs them, or the request says twice how to sample.
        WrongCount: A list of positions does not fit the group.
        NoRegions: The planner is GCS, and no regions fit.
    """
    jobs, settings = submission.jobs, submission.settings
    record = await scenes.get(request.scene, request.revision)
    group = check_request(record, request)
    request.retime.check_group(group)
    require_one_sampling(request.retime.sample_period, request.retime.num_points)
    require_planner(await known_planners(jobs), request.search)
    require_cars(group, request.search)
    loaded = scenes.work(record)
    regions = await select_regions(request, record, loaded.scene, jobs)
    work = PlanWork(
        **dict(loaded),
        request=_settled(request, record, group, regions),
        revision=record.revision,
        cores=_cores(settings),
        regions=regions and await keep_regions(regions, record, jobs),
        cancel_grace=settings.best_grace if request.search.on_cancel == "best" else None,
    )
    return _spec(PLAN, work, record, key)


def _cores(settings: Settings) -> Cores | None:
    """Return how plans share the processors; None where tasks run in threads."""
    if settings.engine == "inline":
        return None
    return Cores(count=settings.search_processes)


async def submit_reversed(plan: Job, key: str | None, scenes: SceneStore, jobs: JobService) -> Job:
    """Queue the reversed motion of a plan, as a plan of its own.

    Raises:
        NotFinished: The plan has no trajectory.
        UnknownResource: Its scene is gone.
        IdempotencyConflict: The key was used for another request.
        QueueFull: The queue is full.
    """
    motion, former = motion_of(plan), work_of(plan)
    record = await scenes.get(former.request.scene, former.revision)
    first, last = motion.result.trajectory.positions
    goal = JointGoal(type="joint", positions=first)
    changes = {"revision": record.revision, "start": last, "goal": goal}
    work = ReverseWork(
        library=scenes.library,
        scene=former.scene,
        request=former.request.model_copy(update=changes),
        revision=record.revision,
        # Reversed twice, a motion has the lines of the first one again.
        origin=former.origin or former.request,
        motion=FirstMotion(
            polynomial=motion.polynomial, path=motion.result.path, parts=motion.result.parts
        ),
    )
    # Two plans with the same ends have the same reversed request, but not the same motion.
    idempotency = IdempotencyKey(key, {"reverse": plan.id})
    return await jobs.submit(_spec(REVERSE, work, record, idempotency))


def _spec[W: MotionWork](
    task: Task[W, PlanOutcome], work: W, record: SceneRecord, key: IdempotencyKey
) -> JobSpec:
    time_limit = work.request.search.allowed_planning_time + SLACK
    return spec_of(task, work, record, key, time_limit, work.request.priority)


def _settled(
    request: PlanRequest, record: SceneRecord, group: Group, regions: SelectedRegions | None
) -> PlanRequest:
    """Return the request with what time would decide: posted again, it gives the same bytes.

    So it does as long as other robots are where they were; a revision says where it has them.
    """
    grown = {} if regions is None else {"regions": regions.id}
    search = request.search.model_copy(update=grown)
    settled: dict[str, Any] = {"revision": record.revision, "search": search}
    if request.start is None and record.moved:
        settled["start"] = group.positions
    return request.model_copy(update=settled)


def require_planner(planners: Sequence[Planner], search: Search) -> None:
    """Go on only if there are such planners, and one of them has such parameters.

    Raises:
        UnknownName: There are not.
    """
    by_name = {planner.name: planner for planner in planners}
    known: set[str] = set()
    for name in search.planners:
        if name not in by_name:
            raise unknown_planner(name, by_name)
        known |= {parameter.name for parameter in by_name[name].parameters}
    for parameter in search.parameters:
        if parameter not in known:
            raise UnknownName.among("parameter", parameter, known)


def require_cars(group: Group, search: Search) -> None:
    """Go on only if the group's bases can drive as requested, and the planners can search for that.

    Raises:
        UnknownName: There is no such planar joint.
        ProblemInvalid: The robot cannot drive so, or a planner checks motions backwards, or the
            planner is GCS and the group can have no regions.
    """
    planar = [joint.name for joint in group.joints if joint.type == "planar"]
    cars = resolve_steering(own_cars(group), search.cars, planar)
    if uses_gcs(search):
        check_eligible(group, cars, "search.planner")
    validate_forward_planners(search.planners, cars)
