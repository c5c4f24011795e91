"""Which regions a plan is given."""

import json
import os
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from planning.errors import ProblemInvalid
from planning.parallel.atomic_files import evict_oldest, write_atomically
from service.errors import NoRegions
from service.jobs.job import Job, JobSummary
from service.jobs.service import JobService
from service.regions.fitness import PLANNER, asks_for_regions
from service.scenes.preflight import require_group
from service.scenes.records import SceneRecord
from service.schemas.plan import PlanRequest
from service.schemas.search import SearchWire

_MOST_NAMED = 20
# Some hundred files; many more than can be waited for at once.
_MOST_BYTES = 2**29


async def chosen_regions(request: PlanRequest, record: SceneRecord, desk: JobService) -> Job | None:
    """Return the regions that a plan is given; None if its planners need none.

    The request names them, or they are the newest that were grown for the very content of the
    scene, whatever its id, for the group and for a margin no less than the plan's. Where nothing
    has grown there is nothing to fit.

    Raises:
        ProblemInvalid: It names regions, and no planner that plans inside them.
        UnknownResource: There are no regions of that id.
        NoRegions: There are none that fit.
    """
    if not asks_for_regions(request.search):
        _require_none(request.search)
        return None
    group = require_group(record, request.group)["name"]
    margin = request.margin
    margin = float(record.document.get("margin") or 0.0) if margin is None else margin
    seen: list[dict[str, Any]] = []
    async for job in _candidates(request, record, desk):
        if _fits(job, record, group, margin):
            return await desk.job("regions", job.id)
        if len(seen) < _MOST_NAMED:
            seen.append(_told(job))
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


def _require_none(search: SearchWire) -> None:
    if search.regions is not None:
        field = "search.regions"
        message = f"{field}: only the planner {PLANNER!r} plans inside regions, and nobody asked it"
        raise ProblemInvalid(message, {"field": field})


async def _candidates(
    request: PlanRequest, record: SceneRecord, desk: JobService
) -> AsyncIterator[JobSummary]:
    if request.search.regions is not None:
        yield await desk.job("regions", request.search.regions)
        return
    async for job in desk.newest("regions", world_digest=record.digest):
        yield job


def _fits(job: JobSummary, record: SceneRecord, group: str, margin: float) -> bool:
    grown = (job.result or {}).get("result")
    return bool(
        grown
        and grown["scene"] == record.digest
        and grown["group"] == group
        and grown["margin"] >= margin
        and grown["num_regions"]
    )


def _told(job: JobSummary) -> dict[str, Any]:
    grown: dict[str, Any] = (job.result or {}).get("result", {})
    named = {name: grown.get(name) for name in ("group", "margin", "scene", "num_regions")}
    return {
        "id": job.id,
        "state": job.state,
        "asked_group": job.payload["request"]["group"],
    } | named


def regions_file(folder: Path, job: Job, most_bytes: int = _MOST_BYTES) -> str:
    """Return the file from which slots read the regions, written if it is not there yet.

    Files that no plan has asked for since many others were are removed: what plans wait for stays.

    Args:
        folder: Of all such files.
        job: That grew the regions.
        most_bytes: Of all files together.
    """
    grown: dict[str, Any] = (job.result or {})["result"]
    path = folder / f"{grown['digest']}.json"
    try:
        os.utime(path)
    except FileNotFoundError:
        write_atomically(path, json.dumps(grown))
        with suppress(OSError):
            evict_oldest(folder, most_bytes)
    return str(path)
