"""Tasks about executions: to carry a motion out, to replay it after."""

from pydantic import Field

from planning.domain.robot.joints import JointType
from service.executions.models import ExecutionStatus, Replanned, SamplingReserve
from service.executions.requests import ExecutionTerms
from service.jobs.outline import Outline
from service.jobs.task import Task, TaskModel
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory import Polynomial
from service.plans.tasks import DeliveredWork, Page
from service.scenes.tasks import SceneWork
from service.trajectories.models import CertifyMotionRequest

# How far a robot may be from where a motion begins [rad or m]; executions end within 0.005.
START_TOLERANCE = 0.02
# Type of the event that says which motion is followed from then on.
MOTION = "motion"


class ExecutionOutline(SceneWork):
    """The part of the work that lists show.

    Attributes:
        replanned: The plan that is carried out instead of the motion that was asked for; None if
            that held.
        joints: Types of the group's joints, by full name and in its order; older versions said
            nothing of them.
        delays: When each of several plans begins [s]; None for one motion.
        is_waiting: Whether it waits for its robots, and nothing is proven of it yet.
        keeps_at_rest: Robots that no other execution may move meanwhile, beside those it moves.
    """

    request: ExecutionTerms
    scene_id: str
    group: str
    speed: float
    replanned: Replanned | None = None
    joints: dict[str, JointType] = Field(default_factory=dict)
    delays: list[float] | None = None
    is_waiting: bool = False
    keeps_at_rest: list[str] = Field(default_factory=list[str])

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots that it moves."""
        names = self.joints or [self.group]  # older versions said nothing of joints
        return tuple(dict.fromkeys(name.partition("::")[0] for name in names))

    @property
    def held_robots(self) -> tuple[str, ...]:
        """Names of the robots that no other execution may move meanwhile."""
        return tuple(dict.fromkeys([*self.robots, *self.keeps_at_rest]))


class WaitingExecution(ExecutionOutline):
    """An execution that waits for its robots.

    Attributes:
        own: The request, if it is a motion of one's own.
        address: Of the controller that will drive it, where there is one.
    """

    own: CertifyMotionRequest | None = None
    address: str | None = None


class MemberMotion(TaskModel):
    """The motion of one of several plans that are carried out as one.

    Attributes:
        planned: Request of the plan, which says what its motion keeps.
        trajectory: Its motion alone.
    """

    planned: PlanRequest
    trajectory: Polynomial


class ExecutionWork(ExecutionOutline):
    """A motion to carry out in a scene.

    Attributes:
        trajectory: The motion.
        planned: Request of the plan that it is of, which says what it keeps; older versions did not
            keep it.
        own: The request, if it is a motion of one's own.
        members: The motions that it is made of, if it is of several plans.
        address: Of the controller that drives it, where there is one: host, and maybe ports.
        clearance: Proven lower bound on all distances [m]; None without any pair.
    """

    trajectory: Polynomial
    address: str | None = None
    clearance: float | None = None
    planned: PlanRequest | None = None
    own: CertifyMotionRequest | None = None
    members: list[MemberMotion] = Field(default_factory=list[MemberMotion])

    @property
    def margins(self) -> list[float | None]:
        """Distances of bodies that were asked for [m]; None for that of the scene."""
        asked = [self.own, self.planned, *(member.planned for member in self.members)]
        return [each.margin for each in asked if each is not None] or [None]


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
        execution: Id of the execution whose motion is in the way, if one is.
    """

    check: str
    pair: list[str]
    time: float
    fraction: float
    revision: int
    execution: str | None = None


class Touch(TaskModel):
    """A contact with a robot that another execution moves; evidence of `Contact`.

    Attributes:
        pair: Full names of both bodies.
        depth: By which they overlap, as measured [m].
        time: Along the motion [s].
        execution: Id of the other execution.
    """

    pair: list[str]
    depth: float
    time: float
    execution: str


class Bounds(TaskModel):
    """Between which places a motion holds in a revision of its scene.

    Attributes:
        revision: Of the scene.
        motion: Number of the motion that it is about.
        behind: Least place on the way back [s]; None if all of it holds.
        ahead: Where it does not hold any more on the way forwards; None if all of it holds.
        leave: Where another motion is to leave it, so it is not passed before [s]; None for none.
    """

    revision: int
    motion: int = 0
    behind: float | None = None
    ahead: Block | None = None
    leave: float | None = None

    @property
    def until(self) -> float | None:
        """Place that is not passed forwards [s]; None for none."""
        places = [self.leave, None if self.ahead is None else self.ahead.time]
        return min((place for place in places if place is not None), default=None)


class NextMotion(TaskModel):
    """A motion that an execution shall go on with.

    Attributes:
        number: Of the motion, 1 for the first one after that which was asked for.
        revision: Of the scene that it is proven in.
        plan: Id of the plan that it follows.
        trajectory: All of it; one that is spliced has what is passed of the motion before it.
        is_spliced: Whether it leaves the motion before it without a rest, at the same place on
            both; if not, the robot rests where it begins.
    """

    number: int
    revision: int
    plan: str
    trajectory: Polynomial
    is_spliced: bool


class Commands(TaskModel):
    """Commands to a running execution, the latest of each kind.

    Attributes:
        is_paused: Whether the robot shall rest on its path.
        speed: Seconds of the motion per second, negative backwards; None for what the request says.
        block: Why it shall come to rest and end; None for no reason.
        bounds: Between which places it shall stay; None for all of its path.
        next: The motion that it shall go on with; None for none.
        touch: What its robot touches, so that it shall hold where it is and end; None for nothing.
    """

    is_paused: bool = False
    speed: float | None = None
    block: Block | None = None
    bounds: Bounds | None = None
    next: NextMotion | None = None
    touch: Touch | None = None


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
    outline=Outline(payload=("trajectory", "planned", "own", "members")),
)
REPLAY_MOTIONS = Task("replay_motions", ReplayWork, Page)
