"""Tasks about executions: to prove a motion before, to carry it out, to replay it after."""

from pydantic import Field

from service.executions.models import ExecutionStatus, SamplingReserve
from service.executions.requests import ExecutionTerms
from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory import Polynomial
from service.plans.tasks import DeliveredWork, Page
from service.scenes.tasks import RequestWork, SceneWork
from service.trajectories.models import CertifyMotionRequest


class ExecutionOutline(SceneWork):
    """The part of the work that lists show."""

    request: ExecutionTerms
    scene_id: str
    group: str
    speed: float


class ExecutionWork(ExecutionOutline):
    """A motion to carry out in a scene.

    Attributes:
        trajectory: The motion.
        address: Of the controller that drives it, where there is one: host, and maybe ports.
        clearance: Proven lower bound on all distances [m]; None without any pair.
    """

    trajectory: Polynomial
    address: str | None = None
    clearance: float | None = None


class ExecutionOutcome(TaskModel):
    """The last status of an execution that reached its end, and the seconds of each stage.

    Attributes:
        status: The last status.
        timings: Seconds of each stage.
        sampling: What is left of the clearance, where a controller samples the motion.
    """

    status: ExecutionStatus
    sampling: SamplingReserve | None = None
    timings: dict[str, float] = Field(default_factory=dict)


class Commands(TaskModel):
    """Commands to a running execution, the latest of each kind.

    Attributes:
        is_paused: Whether the robot shall rest on its path.
        speed: Seconds of the motion per second, negative backwards; None for what the request says.
    """

    is_paused: bool = False
    speed: float | None = None


class ProofWork(SceneWork):
    """A plan's motion to prove in a scene.

    Attributes:
        request: Of the plan.
        origin: Of a motion backwards, the request of the plan forwards.
        trajectory: The motion.
    """

    request: PlanRequest
    origin: PlanRequest | None
    trajectory: Polynomial


class Proof(TaskModel):
    """A lower bound on the distance of all pairs [m]; infinite, and null as JSON, without any."""

    min_clearance: float | None


class ProvenMotion(TaskModel):
    """A motion that is proven.

    Attributes:
        trajectory: Its exact polynomial.
        start: Its first configuration.
        min_clearance: As of `Proof`.
    """

    trajectory: Polynomial
    start: list[float]
    min_clearance: float | None


class ShownWork(DeliveredWork):
    """A motion of a replay: what stands above it, and when it ended [s], if before its end."""

    title: str
    until: float | None


class ReplayWork(TaskModel):
    """Motions that are replayed one after the other, each in a scene of its own."""

    artifact_members = ("motions.scene.document",)

    motions: list[ShownWork]


EXECUTE = Task(
    "execute",
    ExecutionWork,
    ExecutionOutcome,
    queue="execution",
    # A robot that has moved is not where a second attempt would begin.
    max_attempts=1,
    outline=Outline(payload=("trajectory",)),
)
PROVE = Task("prove_execution", ProofWork, Proof)
PROVE_MOTION = Task("prove_motion", RequestWork[CertifyMotionRequest], ProvenMotion)
REPLAY_MOTIONS = Task("replay_motions", ReplayWork, Page)
