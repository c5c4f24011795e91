"""Which regions a plan is given."""

from collections.abc import AsyncIterator
from dataclasses import dataclass

from planning.errors import ProblemInvalid
from service.errors import NoRegions
from service.jobs.artifacts import Artifact
from service.jobs.job import JobSummary
from service.jobs.json_steps import member_of
from service.jobs.json_text import Encoded
from service.jobs.service import JobService
from service.plans.models.request import PlanRequest
from service.plans.models.search import Search
from service.regions.models import RegionsSummary
from service.regions.tasks import RegionsOutline, RegionsWork
from service.scenes.store.records import SceneRecord
from service.scenes.tasks import StoredScene
from service.scenes.validation import find_group

PLANNER = "GCS"
_MAX_NAMED = 20


def uses_gcs(search: Search) -> bool:
    """Return whether the planner that plans inside regions is among those asked for."""
    return PLANNER in search.planners


@dataclass(frozen=True)
class SelectedRegions:
    """Regions that a plan is given.

    Attributes:
        id: Of their job.
        outcome: What the job gave, whole.
    """

    id: str
    outcome: Encoded


async def select_regions(
    request: PlanRequest, record: SceneRecord, scene: StoredScene, jobs: JobService
) -> SelectedRegions | None:
    """Return the regions that a plan is given; None if its planners need none.

    The request names them, or they are the newest that were grown for the very content of the
    scene, whatever its id, with its robots where they are, for the group and for a margin no less
    than the plan's. Where nothing has grown there is nothing to fit.

    Raises:
        ProblemInvalid: It names regions, and no planner that plans inside them.
        UnknownResource: There are no regions of that id.
        NoRegions: There are none that fit.
    """
    if not uses_gcs(request.search):
        _check_unnamed(request.search)
        return None
    group = find_group(record, request.group).name
    margin = request.margin
    margin = float(record.document.get("margin") or 0.0) if margin is None else margin
    seen: list[dict[str, object]] = []
    async for job in _candidates(request, record, jobs):
        grown = _grown(job)
        is_same = RegionsWork.model_validate(job.payload).scene.is_same(scene)
        if grown is not None and is_same and _fits(grown, group, margin):
            outcome = (await jobs.job_text("regions", job.id)).result
            return SelectedRegions(job.id, outcome or Encoded("{}"))
        if len(seen) < _MAX_NAMED:
            seen.append(_describe(job, grown))
    raise NoRegions(
        f"the planner {PLANNER!r} needs regions of group {group!r} that keep {margin:g} m in this "
        f"revision of the scene; grow them by POST /v1/scenes/{record.id}/regions",
        {
            "scene": record.id,
            "digest": record.digest,
            "group": group,
            "margin": margin,
            "there": seen,
        },
    )


def _check_unnamed(search: Search) -> None:
    if search.regions is not None:
        field = "search.regions"
        message = f"{field}: only the planner {PLANNER!r} plans inside regions, and nobody asked it"
        raise ProblemInvalid(message, {"field": field})


async def _candidates(
    request: PlanRequest, record: SceneRecord, jobs: JobService
) -> AsyncIterator[JobSummary]:
    if request.search.regions is not None:
        yield (await jobs.job_text("regions", request.search.regions)).summary
        return
    async for job in jobs.newest("regions", world_digest=record.digest):
        yield job


def _grown(job: JobSummary) -> RegionsSummary | None:
    return None if job.result is None else RegionsOutline.model_validate(job.result).result


def _fits(grown: RegionsSummary, group: str, margin: float) -> bool:
    return grown.group == group and grown.margin >= margin and grown.num_regions > 0


def _describe(job: JobSummary, grown: RegionsSummary | None) -> dict[str, object]:
    names = ("group", "margin", "scene", "num_regions")
    return {
        "id": job.id,
        "state": job.state,
        "asked_group": RegionsWork.model_validate(job.payload).request.group,
        **{name: getattr(grown, name, None) for name in names},
    }


async def keep_regions(regions: SelectedRegions, record: SceneRecord, jobs: JobService) -> str:
    """Return the digest of the artifact from which workers read the regions of a scene."""
    text = member_of(regions.outcome.text, "result") or "null"
    return await jobs.keep_artifact(Artifact(text.encode()), record.digest)
