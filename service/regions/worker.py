"""Growing regions, as a job; and reading what was grown, for plans."""

import time
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path

from planning import Deadline, Regions, grow_regions
from planning.domain.report.motion_plan import Progress
from planning.domain.request.stopwatch import Stopwatch
from service.jobs.context import TaskContext
from service.jobs.worker.progress import ProgressReporter
from service.regions.models import RegionsResult
from service.regions.tasks import GROW_REGIONS, RegionsOutcome, RegionsWork
from service.scenes.world_cache import borrow_world


@GROW_REGIONS.runs
def grow(work: RegionsWork, context: TaskContext) -> RegionsOutcome:
    """Return regions in full, and the seconds of each stage.

    Raises:
        WayproofError: The group can have no regions, or the end was asked for.
    """
    request = work.request
    progress = ProgressReporter(context)
    progress(Progress("load", 0.0))
    watch = Stopwatch(time.monotonic)
    with watch.timing_failures(), ExitStack() as stack:
        with watch.stage("load"):
            world = stack.enter_context(borrow_world(work))
        with watch.stage("regions"):
            regions = grow_regions(
                world,
                request.group,
                deadline=Deadline.after(request.allowed_time, time.monotonic, context.is_canceled),
                options=request.to_domain(),
                seed=request.seed,
                on_progress=progress,
            )
    result = RegionsResult.from_domain(regions)
    return RegionsOutcome(result=result, timings=watch.seconds_by_name)


@lru_cache(maxsize=8)
def read_regions(path: Path) -> Regions:
    """Return regions from a file, which is named by its content."""
    text = path.read_text(encoding="utf-8")
    return RegionsResult.model_validate_json(text).to_domain()
