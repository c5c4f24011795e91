"""Tasks that plan motions, reverse them, and make what is delivered of them."""

from typing import Annotated, Any

from pydantic import Field, PlainSerializer

from planning.domain.curves.sampling import Sampling
from planning.domain.report.motion_plan import PlanPart
from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.plans.exports.formats import FormatName
from service.plans.exports.series import Series
from service.plans.models.request import PlanRequest, Retime
from service.plans.models.result import PlanResult
from service.plans.models.search_reports import PlannerGraph
from service.plans.models.trajectory import Polynomial, Trajectory
from service.scenes.tasks import SceneWork

# JSON has no infinity.
type MaybeInfinite = Annotated[float, PlainSerializer(str, when_used="json")]


def _is_none(value: object) -> bool:
    return value is None


class NoWork(TaskModel):
    """Nothing."""


class WarmedUp(TaskModel):
    """Whether a worker plans as it should."""

    proven: bool


class Cores(TaskModel):
    """How many processors the plans of a host share.

    Attributes:
        count: How many processors there are to share.
    """

    count: int


class MotionWork(SceneWork):
    """What plans and reversed plans have in common, as jobs store it.

    Attributes:
        request: As it was posted, with what time would decide.
        revision: Of the scene.
        origin: Of a reversed plan, the request of the first motion: what both were made to keep.
    """

    request: PlanRequest
    revision: int
    origin: PlanRequest | None = Field(default=None, exclude_if=_is_none)


class PlanWork(MotionWork):
    """What a plan is made from.

    Attributes:
        cores: None where attempts are made one after another.
        regions: sha256 of the artifact that has the regions that it plans in, if any.
        cancel_grace: How long it may go on once it is canceled, if that is not the usual [s].
    """

    artifact_members = ("scene.document", "regions")

    cores: Cores | None = None
    regions: str | None = Field(default=None, exclude_if=_is_none)
    cancel_grace: float | None = Field(default=None, exclude_if=_is_none)


class FirstMotion(TaskModel):
    """The motion that is to be reversed."""

    polynomial: Polynomial
    path: list[list[float]]
    parts: tuple[PlanPart, ...]


class ReverseWork(MotionWork):
    """What a reversed plan is made from; its origin is always there."""

    motion: FirstMotion


class PlanOutcome(TaskModel):
    """What a job keeps of a plan.

    Attributes:
        result: What clients are given.
        polynomial: The exact trajectory.
        timings: Seconds per stage.
        digest: sha256 over the delivered numbers.
        cut_short: Stages that the clock ended early.
        graph: What the planner explored, if it was to be kept.
    """

    result: PlanResult
    polynomial: Polynomial
    timings: dict[str, float]
    digest: str
    cut_short: list[str]
    graph: PlannerGraph | None


class DeliveredWork(SceneWork):
    """A delivered motion in its scene."""

    group: str
    trajectory: Polynomial


class SampleWork(DeliveredWork):
    """What a delivered motion is sampled anew from.

    Attributes:
        request: What it was made to keep.
        parts: Of the motion.
        clearance: What the certificate says that no distance is below [m].
        sampling: At which instants.
        scale: Factor on the speed of the whole motion.
        polynomial: Whether to add the exact polynomial.
    """

    request: PlanRequest
    parts: tuple[PlanPart, ...]
    clearance: MaybeInfinite
    sampling: Sampling
    scale: float
    polynomial: bool


class Table(TaskModel):
    """Samples as CSV, and a line that says what is proven of them."""

    text: str
    proven: str


class ExportWork(SampleWork):
    """What a file of another program is made from."""

    format: FormatName


class ExportedFile(TaskModel):
    """A file in base64, and a line that says what is proven of its samples."""

    base64: str
    proven: str


class PlotWork(DeliveredWork):
    """What charts are drawn from: the motion, and the limits that it was made to keep.

    Attributes:
        names: Of the charts.
        retime: Has the limits.
        margin: That distances keep [m]; None for the scene's.
    """

    names: tuple[str, ...]
    retime: Retime
    margin: float | None


class SeriesWork(DeliveredWork):
    """What the numbers of plots are made from: the motion, and the limits that it was to keep.

    Attributes:
        num_samples: Number of instants, at least 2.
        distances: Whether to measure distances of bodies.
    """

    retime: Retime
    margin: float | None
    num_samples: int
    distances: bool


class Drawing(TaskModel):
    """A chart as SVG."""

    svg: str


class Drawings(TaskModel):
    """Charts as SVG, by name."""

    svg: dict[str, str]


class MotionPictures(TaskModel):
    """Pictures of a motion: what they show in words, and PNG files in base64."""

    captions: list[str]
    base64: list[str]


NO_PICTURES = MotionPictures(captions=[], base64=[])


class PictureWork(DeliveredWork):
    """A delivered motion to draw in its scene.

    Attributes:
        nearest_at: When two bodies are nearest [s]; None if nothing can collide.
        pair: Full names of those two; empty for none.
        points: Their nearest points then, shape (2, 3) [m]; empty where they are not known.
    """

    nearest_at: float | None
    pair: list[str]
    points: list[list[float]]


class FailureWork(SceneWork):
    """A plan that failed, in its scene.

    Attributes:
        plan: Its id.
        request: What it was to do.
        failure: Why it did not, as the job has it.
    """

    plan: str
    request: PlanRequest
    failure: dict[str, Any]


class Page(TaskModel):
    """A page that needs nothing else."""

    html: str


_LARGE = Outline(
    payload=("motion",),
    result=("result", "polynomial", "graph"),
    failure=("evidence.graph",),
)
PLAN = Task("plan", PlanWork, PlanOutcome, queue="plan", outline=_LARGE)
REVERSE = Task("reverse", ReverseWork, PlanOutcome, queue="plan", outline=_LARGE)
SAMPLE = Task("sample_plan", SampleWork, Trajectory)
SAMPLE_TABLE = Task("sample_plan_as_table", SampleWork, Table)
EXPORT = Task("export_plan", ExportWork, ExportedFile)
PLOT = Task("plot_plan", PlotWork, Drawing)
SERIES = Task("series_of_plan", SeriesWork, Series)
PLOT_ALL = Task("plot_all_of_plan", PlotWork, Drawings)
PICTURES = Task("pictures_of_plan", PictureWork, MotionPictures)
SHOW_FAILURE = Task("show_failure", FailureWork, Page)
REPLAY = Task("replay_plan", DeliveredWork, Page)
WARM_UP = Task("warm_up", NoWork, WarmedUp)
