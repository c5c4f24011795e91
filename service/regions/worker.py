"""Growing regions, as a job; and reading what was grown, for plans."""

import json
import time
from functools import lru_cache
from pathlib import Path
from typing import Any

from planning import Deadline, Regions, grow_regions
from planning.domain.report.motion_plan import Progress
from service.jobs.context import TaskContext
from service.plans.progress import ProgressReporter
from service.regions.conversion import region_options_value, regions_value, regions_wire
from service.regions.models import RegionsRequest
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world


def grow(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return the `result`, regions in full, and `timings` [s].

    Raises:
        WayproofError: The group has no regions, or somebody asked for the end.
    """
    request = RegionsRequest.model_validate(payload["request"])
    log = ProgressReporter(channel)
    log(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(SceneWork.model_validate(payload)) as world:
        loaded = time.monotonic()
        deadline = Deadline.after(request.allowed_time, time.monotonic, channel.is_canceled)
        regions = grow_regions(
            world,
            request.group,
            deadline=deadline,
            options=region_options_value(request),
            seed=request.seed,
            on_progress=log,
        )
    timings = {"load": loaded - begun, "regions": time.monotonic() - loaded}
    return {"result": regions_wire(regions), "timings": timings}


@lru_cache(maxsize=8)
def read_regions(path: str) -> Regions:
    """Return regions from a file, which is named by their content."""
    return regions_value(json.loads(Path(path).read_text(encoding="utf-8")))
