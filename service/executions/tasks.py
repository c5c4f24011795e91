"""Tasks about executions: to prove a motion before, to carry it out, to replay it after."""

from pydantic import Field

from planning.domain.robot.joints import JointType
from service.executions.models import ExecutionStatus, SamplingReserve
from service.executions.requests import ExecutionTerms
from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory import Polynomial
from service.plans.tasks import DeliveredWork, Page
from service.scenes.tasks import RequestWork, SceneWork
from service.trajectories.models import CertifyMotionRequest

# How far a robot may be from where a motion begins [rad or m]; executions end within 0.005.
START_TOLERANCE = 0.02


class ExecutionOutline(SceneWork):
    """The part of the work that lists show.

    Attributes:
        joints: Types of the group's joints, by full name and in its order; older versions said
            nothing of them.
    """

    request: ExecutionTerms
    scene_id: str
    group: str
    speed: float
    joints: dict[str, JointType] = Field(default_factory=dict)


class ExecutionWork(ExecutionOutline):
    """A motion to carry out in a scene.

    Attributes:
        trajectory: The motion.
        planned: Request of the plan that it is of, which says what it keeps; older versions did not
            keep it.
        own: The request, if it is a motion of one's own.
        address: Of the controller that drives it, where there is one: host, and maybe ports.
        clearance: Proven lower bound on all distances [m]; None without any pair.
    """

    trajectory: Polynomial
    address: str | None = None
    clearance: float | None = None
    planned: PlanRequest | None = None
    own: CertifyMotionRequest | None = None


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


class Block(TaskModel):
    """Where a motion does not hold any more since its scene was edited; evidence of `PathBlocked`.

    Attributes:
        check: Of the certificate.
        pair: Full names of both bodies, if it is about two.
        time: Along the motion [s].
        fraction: Share of the path's length there.
        revision: Of the scene.
    """

    check: str
    pair: list[str]
    time: float
    fraction: float
    revision: int


class Commands(TaskModel):
    """Commands to a running execution, the latest of each kind.

    Attributes:
        is_paused: Whether the robot shall rest on its path.
        speed: Seconds of the motion per second, negative backwards; None for what the request says.
        block: Why it shall come to rest and end; None for no reason.
    """

    is_paused: bool = False
    speed: float | None = None
    block: Block | None = None


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


class RecheckWork(SceneWork):
    """A motion that is carried out, to prove again in its scene as that was edited.

    Attributes:
        planned: Request of the plan that it is of, which says what it keeps.
        own: The request, if it is a motion of one's own.
        trajectory: The whole motion.
        since: Where the robot is along it [s].
        revision: Of the scene.
    """

    planned: PlanRequest | None
    own: CertifyMotionRequest | None
    trajectory: Polynomial
    since: float
    revision: int


class Recheck(TaskModel):
    """The verdict: where the motion is blocked; None if what is left of it holds."""

    block: Block | None


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
    outline=Outline(payload=("trajectory", "planned", "own")),
)
PROVE = Task("prove_execution", ProofWork, Proof)
RECHECK = Task("recheck_motion", RecheckWork, Recheck)
PROVE_MOTION = Task("prove_motion", RequestWork[CertifyMotionRequest], ProvenMotion)
REPLAY_MOTIONS = Task("replay_motions", ReplayWork, Page)
