"""/v1/plans/{id}/trajectory, replay.html, plots: what a plan delivered, to use and to look at."""

from base64 import b64decode
from typing import Annotated, Literal

from fastapi import APIRouter, Path, Query, Response
from fastapi.responses import HTMLResponse

from service.api.dependencies import JobsDep
from service.api.responses import HTML_PAGE, passed_on, problems
from service.api.routing.strict_route import StrictRoute
from service.plans.dependencies import PlanJob
from service.plans.exports.formats import FORMATS
from service.plans.exports.series import Series
from service.plans.models.trajectory import Trajectory
from service.plans.resource import delivered_work, motion_of, plot_work, work_of
from service.plans.tasks import (
    EXPORT,
    PLOT,
    REPLAY,
    SAMPLE,
    SAMPLE_TABLE,
    SERIES,
    ExportWork,
    SampleWork,
    SeriesWork,
)

router = APIRouter(route_class=StrictRoute, prefix="/v1/plans/{plan}", tags=["plans"])

type Format = Annotated[
    Literal["json", "csv", "ros2", "npz", "urscript", "mcap", "rerun"],
    Query(
        description="Format of the answer: `ros2` is a `JointTrajectory` as JSON, `npz` has arrays "
        "of NumPy, `urscript` is a program for Universal Robots, `mcap` a log for Foxglove and "
        "`rerun` a recording for Rerun, both with the scene"
    ),
]
type Period = Annotated[
    float | None,
    Query(
        ge=1e-4,
        le=10,
        allow_inf_nan=False,
        description="Longest time between samples [s]: they lie where the pieces of the "
        "motion meet, and evenly between; none for the plan's `sample_period`",
    ),
]
type Points = Annotated[
    int | None,
    Query(
        ge=2,
        le=200_000,
        description="Number of samples, evenly in time, first and last instants included; "
        "not together with `period`",
    ),
]
type Even = Annotated[
    bool,
    Query(
        description="Whether samples are exactly `period` apart, but for the last, "
        "wherever the pieces of the motion meet"
    ),
]
type Slowness = Annotated[
    float,
    Query(
        gt=0.001,
        le=1,
        allow_inf_nan=False,
        description="Factor on the speed of the whole motion: 0.5 takes twice as long",
    ),
]
type Exact = Annotated[
    bool, Query(description="Whether to add the exact piecewise polynomial (JSON only)")
]

type Chart = Annotated[
    Literal[
        "acceleration",
        "clearance",
        "jerk",
        "position",
        "tool_speed",
        "torque",
        "utilisation",
        "velocity",
    ],
    Path(description="Quantity to draw over time, against the limits that the plan keeps"),
]

type NumSamples = Annotated[
    int, Query(ge=2, le=2000, description="Number of instants, evenly in time, both ends included")
]
type Distances = Annotated[
    bool,
    Query(description="Whether to measure distances of bodies too, which takes most of the time"),
]

# The header that says what is proven of a table.
INTERPOLATION = "wayproof-interpolation"

_SVG = {"schema": {"type": "string", "description": "A drawing"}}
_CSV = {"schema": {"type": "string", "description": "A header, then a row per instant"}}
_TOLD = {
    INTERPOLATION: {
        "description": "Verdict on the samples, as `linear=proven, cubic=unproven, "
        "quintic=proven`; in all formats but JSON",
        "schema": {"type": "string"},
    }
}
_FILES = {
    form.media_type: {"schema": {**form.schema, "description": form.told}}
    for form in FORMATS.values()
}


@router.get(
    "/trajectory",
    operation_id="getTrajectory",
    response_model=Trajectory,
    responses={
        200: {"content": {"text/csv": _CSV, **_FILES}, "headers": _TOLD},
        **problems(404, 409, 422, 429, 503),
    },
)
async def get_trajectory(  # noqa: PLR0913  (one parameter per query)
    job: PlanJob,
    jobs: JobsDep,
    *,
    format: Format = "json",  # noqa: A002  (the contract's name)
    period: Period = None,
    points: Points = None,
    even: Even = False,
    scale: Slowness = 1.0,
    polynomial: Exact = False,
) -> Response:
    """Sample the motion of a plan anew, slower if `scale` says so, and prove the samples."""
    result, made = motion_of(job).result, work_of(job)
    work = SampleWork(
        **dict(delivered_work(job)),
        request=made.origin or made.request,
        parts=result.parts,
        clearance=result.certificate.proven_clearance,
        sampling=made.request.retime.sampling_with(period, points, even=even),
        scale=scale,
        polynomial=polynomial and format == "json",
    )
    if format == "json":
        return passed_on(await jobs.call_text(SAMPLE, work))
    if format == "csv":
        table = await jobs.call(SAMPLE_TABLE, work)
        headers = {INTERPOLATION: table.proven}
        return Response(table.text, media_type="text/csv", headers=headers)
    file = await jobs.call(EXPORT, ExportWork(**dict(work), format=format))
    headers = {INTERPOLATION: file.proven}
    return Response(b64decode(file.base64), media_type=FORMATS[format].media_type, headers=headers)


@router.get(
    "/replay.html",
    operation_id="getReplay",
    response_class=HTMLResponse,
    responses={200: HTML_PAGE, **problems(404, 409, 422, 429, 503)},
)
async def get_replay(job: PlanJob, jobs: JobsDep) -> HTMLResponse:
    """Replay the motion in 3-D: a self-contained page of Drake's Meshcat."""
    page = await jobs.call(REPLAY, delivered_work(job))
    return HTMLResponse(page.html)


@router.get(
    "/plots/{name}.svg",
    operation_id="getPlot",
    response_class=Response,
    responses={200: {"content": {"image/svg+xml": _SVG}}, **problems(404, 409, 422, 429, 503)},
)
async def get_plot(job: PlanJob, jobs: JobsDep, name: Chart) -> Response:
    """Draw the motion of a plan against its limits, or its clearance, over time."""
    drawing = await jobs.call(PLOT, plot_work(job, name))
    return Response(drawing.svg, media_type="image/svg+xml")


@router.get(
    "/series",
    operation_id="getSeries",
    response_model=Series,
    responses=problems(404, 409, 422, 429, 503),
)
async def get_series(
    job: PlanJob, jobs: JobsDep, *, points: NumSamples = 201, distances: Distances = False
) -> Response:
    """Return the numbers of the plots: rates, efforts, limits and their use over time."""
    request = work_of(job).request
    work = SeriesWork(
        **dict(delivered_work(job)),
        retime=request.retime,
        margin=request.margin,
        num_samples=points,
        distances=distances,
    )
    return passed_on(await jobs.call_text(SERIES, work))
