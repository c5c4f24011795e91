"""The task that grows regions, and what its job keeps."""

from pydantic import Field

from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.regions.models import RegionsRequest, RegionsResult, RegionsSummary
from service.scenes.tasks import SceneWork


class RegionsWork(SceneWork):
    """Regions to grow in a revision of a scene."""

    request: RegionsRequest
    revision: int


class RegionsOutline(TaskModel):
    """The part of an outcome that lists show."""

    result: RegionsSummary
    timings: dict[str, float] = Field(default_factory=dict)


class RegionsOutcome(TaskModel):
    """Regions in full, and the seconds of each stage."""

    result: RegionsResult
    timings: dict[str, float]


GROW_REGIONS = Task(
    "grow_regions",
    RegionsWork,
    RegionsOutcome,
    queue="regions",
    outline=Outline(result=("result.regions", "result.portals")),
)
