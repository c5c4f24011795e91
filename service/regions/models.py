"""Regions: convex sets of free configurations, grown in the background, as JSON."""

from datetime import datetime
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, Strict

from planning.domain.planner import regions as domain
from service.api.document.open_enums import AnyStage, OneOf
from service.api.failures.failure import Failure
from service.api.fingerprint import ADDED
from service.api.models import (
    ATTEMPTS,
    CANCEL_REQUESTED_AT,
    GROUP,
    PRIORITY,
    UNRECORDED,
    WHOLE,
    GroupName,
    Interval,
    NonNegative,
    PositionName,
    Real,
    RequestModel,
    ResponseModel,
    Timings,
    Versions,
)
from service.jobs.job import Priority
from service.jobs.states import JobState

StopReason = Annotated[
    str,
    OneOf(
        "RegionsStopReason",
        "Reason why there are no more regions.",
        ("coverage", "num_regions", "deadline", "exhausted"),
    ),
]


class RegionsRequest(RequestModel):
    """Grow regions for a group of a scene."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"group": "arm", "num_regions": 40}]})

    group: GroupName = Field(description=GROUP)
    revision: Annotated[int, Strict(), Field(ge=1), WHOLE] | None = Field(
        default=None, description="Revision of the scene; null for its latest"
    )
    num_regions: Annotated[int, Strict(), Field(ge=1, le=1000), WHOLE] = Field(
        default=60, description="Largest number of regions"
    )
    coverage: Annotated[Real, Field(gt=0, le=1)] = Field(
        default=0.9,
        description="Coverage at which growth ends, as a share of the free configurations in the "
        "domain [1]",
    )
    along: Literal["paths", "nothing"] = Field(
        default="paths",
        description="Regions that come first: those along paths from the scene's state to "
        "the group's named configurations and the scene's frames (`paths`), "
        "or none but the cover (`nothing`)",
    )
    num_free: Annotated[int, Strict(), Field(ge=100, le=1_000_000), WHOLE] = Field(
        default=5000,
        description="Number of consecutive random configurations of a region that must be free",
    )
    iterations: Annotated[int, Strict(), Field(ge=1, le=20), WHOLE] = Field(
        default=3,
        description="Number of times that a region is grown anew around its largest ellipsoid",
    )
    bounds: dict[PositionName, Interval] = Field(
        default={},
        max_length=256,
        description="Lowest and highest value to grow in [rad or m], by position name, within the "
        "limits; angles that may turn further are taken from -pi to pi, those on a circle over "
        "one turn at most",
    )
    margin: Annotated[NonNegative, Field(le=10)] | None = Field(
        default=None, description="Distance that regions keep [m]; null for the scene's"
    )
    padding: Annotated[NonNegative, Field(le=1)] = Field(
        default=0.001, description="Distance beyond the margin, for proofs to be quick [m]"
    )
    allowed_time: Annotated[Real, Field(gt=0, le=86_400)] = Field(
        default=600.0, description="Time after which the regions that have grown are the result [s]"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**32 - 1), WHOLE] = Field(
        default=0, description="Seed of all randomness: the same seed gives the same regions"
    )
    priority: Annotated[Priority, ADDED] = Field(default=Priority.NORMAL, description=PRIORITY)

    def to_domain(self) -> domain.RegionOptions:
        """Return the options of the growth."""
        return domain.RegionOptions(
            num_regions=self.num_regions,
            coverage=self.coverage,
            along=self.along,
            num_free=self.num_free,
            iterations=self.iterations,
            bounds={name: (low, high) for name, (low, high) in self.bounds.items()},
            margin=self.margin,
            padding=self.padding,
        )


class Region(ResponseModel):
    """A region: those configurations q with normals q <= offsets."""

    normals: list[list[float]] = Field(description="Unit normals of its faces, a row each")
    offsets: list[float] = Field(description="Offset of each face [rad or m]")
    center: list[float] = Field(description="A configuration well inside [rad or m]")
    num_free: int = Field(
        description="Number of consecutive random configurations that were free: with 95 % "
        "confidence less than 3 / num_free of its volume collides"
    )


class Portal(ResponseModel):
    """Overlap of two regions."""

    regions: tuple[int, int] = Field(description="Indices of the two in the list of regions")
    point: list[float] = Field(description="Center of the largest ball in both [rad or m]")
    radius: float = Field(description="Radius of that ball [rad or m]")


class RegionsSummary(ResponseModel):
    """Regions that were grown, without their faces."""

    digest: str = Field(description="sha256 over all numbers of the regions")
    scene: str = Field(description="Digest of the scene in which they are free of collision")
    group: str = Field(description="Group of the configurations")
    margin: float = Field(description="Distance that they keep [m]")
    seed: int = Field(description="Seed of all randomness")
    num_regions: int = Field(description="Number of regions")
    num_portals: int = Field(description="Number of pairs of regions that overlap")
    coverage: float = Field(
        description="Share of the domain's free configurations that some region holds, by sampling"
    )
    coverage_error: float = Field(description="Standard error of `coverage`")
    stopped_by: StopReason = Field(
        description="Reason why there are no more: `coverage`, `num_regions`, `deadline` "
        "or `exhausted`"
    )
    lower: list[float] = Field(description="Lowest configuration of the domain [rad or m]")
    upper: list[float] = Field(description="Highest configuration of the domain [rad or m]")


class RegionsResult(RegionsSummary):
    """Regions that were grown, with their faces."""

    regions: list[Region] = Field(description="Regions in the order in which they were grown")
    portals: list[Portal] = Field(description="Overlaps of the regions")

    @classmethod
    def from_domain(cls, regions: domain.Regions) -> Self:
        """Return regions in full."""
        return cls(
            **regions.as_json,
            num_regions=len(regions.regions),
            num_portals=len(regions.portals),
            digest=regions.digest,
        )

    def to_domain(self) -> domain.Regions:
        """Return the regions, bit for bit as they were."""
        derived = {"num_regions", "num_portals", "digest"}
        return domain.Regions.from_json(self.model_dump(exclude=derived))


class RegionsBrief(ResponseModel):
    """A request for regions and its state, without faces."""

    id: str = Field(description="Id of the regions")
    state: JobState = Field(
        description="State of the growth; succeeded, failed and canceled are final"
    )
    stage: AnyStage = Field(description="Stage that it is in, `load` or `regions`, or empty")
    progress: float = Field(description="Share of the work that is done, 0 to 1", ge=0, le=1)
    created_at: datetime = Field(description="Time of the request (UTC)")
    started_at: datetime | None = Field(description="Time at which a worker began (UTC)")
    finished_at: datetime | None = Field(description="Time at which it ended (UTC)")
    cancel_requested_at: datetime | None = Field(description=CANCEL_REQUESTED_AT)
    attempts: int = Field(description=ATTEMPTS)
    scene: str = Field(description="Id of the scene")
    revision: int = Field(description="Revision of the scene")
    request: RegionsRequest = Field(description="The request, defaults filled in")
    failure: Failure | None = Field(description="Reason why there is no result")
    versions: Versions = Field(
        description="Versions of everything that the numbers depend on, in the server that ran "
        "it last; "
        "empty before it runs, and for regions of versions that did not keep it"
    )
    timings: Timings = Field(
        description="Seconds per stage, once it has ended; of a failure those of `failure` [s]"
    )
    unrecorded: list[str] = Field(description=UNRECORDED)
    summary: RegionsSummary | None = Field(
        description="The regions without their faces, once it succeeded"
    )


class RegionsJob(RegionsBrief):
    """A request for regions with its result; poll it until its state is final."""

    result: RegionsResult | None = Field(description="The regions, once it succeeded")


class RegionsPage(ResponseModel):
    """Regions, newest first."""

    items: list[RegionsBrief] = Field(description="Regions on this page, without their faces")
    next: str | None = Field(description="Cursor of the next page; null on the last one")
