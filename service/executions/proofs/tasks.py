"""Tasks that prove motions: before they are carried out, beside others, after an edit, spliced."""

from typing import Self

from service.executions.gripping.requests import GripperRequest
from service.executions.tasks import Block, ExecutionWork, MemberMotion
from service.jobs.task import Task, TaskModel
from service.plans.models.request import PlanRequest
from service.plans.models.trajectory import Polynomial
from service.scenes.tasks import RequestWork, SceneWork
from service.trajectories.models import CertifyMotionRequest


class GroupMotion(TaskModel):
    """The motion of an execution, as others are proven beside it.

    Attributes:
        execution: Its id; empty for one that has none yet.
        group: That moves.
        trajectory: All of the motion.
        margins: Distances of bodies that were asked for [m]; None for that of the scene.
    """

    execution: str
    group: str
    trajectory: Polynomial
    margins: list[float | None]

    @classmethod
    def of(cls, execution: str, work: ExecutionWork) -> Self:
        """Return the motion of an execution."""
        return cls(
            execution=execution,
            group=work.group,
            trajectory=work.trajectory,
            margins=work.margins,
        )


class BesideWork(SceneWork):
    """A motion to prove beside those of other executions, whatever the timing of each.

    Attributes:
        motion: The motion.
        others: The other motions.
    """

    motion: GroupMotion
    others: list[GroupMotion]


class BesideProof(TaskModel):
    """That a motion is proven beside others: how many these are."""

    num_others: int


class SpliceWork(SceneWork):
    """A motion to be left at an instant, for another one.

    Attributes:
        planned: Request of the plan that it is of, which says what it keeps.
        own: The request, if it is a motion of one's own.
        running: The whole motion.
        time: When it is left [s].
        onto: The motion that is joined.
    """

    planned: PlanRequest | None
    own: CertifyMotionRequest | None
    running: Polynomial
    time: float
    onto: Polynomial


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


class GripperWork(SceneWork):
    """What a gripper shall do in a scene.

    Attributes:
        request: What.
        group: The gripper.
        tool_frame: That it holds objects in, if the request names none.
    """

    request: GripperRequest
    group: str
    tool_frame: str


class RecheckWork(SceneWork):
    """A motion that is carried out, to prove again in its scene as that was edited.

    Attributes:
        planned: Request of the plan that it is of, which says what it keeps.
        own: The request, if it is a motion of one's own.
        members: The motions that it is made of, if it is of several plans.
        group: That moves.
        trajectory: The whole motion.
        since: Where the robot is along it [s].
        revision: Of the scene.
        others: The motions of the other executions in the scene.
        margins: Distances of bodies that were asked for [m]; None for that of the scene.
        gripper: What a gripper shall do, if it is the motion of one.
    """

    planned: PlanRequest | None
    own: CertifyMotionRequest | None
    members: list[MemberMotion]
    gripper: GripperRequest | None = None
    group: str
    trajectory: Polynomial
    since: float
    revision: int
    others: list[GroupMotion]
    margins: list[float | None]


class Recheck(TaskModel):
    """The verdict on a motion from where the robot is.

    Attributes:
        block: Where it does not hold on the way forwards; None if it does.
        behind: Until where it holds on the way back [s]; None for all of it.
    """

    block: Block | None
    behind: float | None = None


class TogetherWork(SceneWork):
    """Motions of several plans to prove as one in a scene.

    Attributes:
        members: The motions, the most urgent first.
        delays: When each begins [s]; None for the smallest that are proven.
    """

    members: list[MemberMotion]
    delays: list[float] | None


class Proof(TaskModel):
    """A lower bound on the distance of all pairs [m]; infinite, and null as JSON, without any."""

    min_clearance: float | None


class ProvenMotion(TaskModel):
    """A motion that is proven.

    Attributes:
        trajectory: Its exact polynomial.
        start: Its first configuration.
        min_clearance: As of `Proof`.
        delays: When each of several plans begins [s]; None for one motion.
    """

    trajectory: Polynomial
    start: list[float]
    min_clearance: float | None
    delays: list[float] | None = None


class Spliced(TaskModel):
    """A motion up to where it is left, and on from there without a rest; None if none is proven."""

    trajectory: Polynomial | None


PROVE = Task("prove_execution", ProofWork, Proof)
RECHECK = Task("recheck_motion", RecheckWork, Recheck)
SPLICE = Task("splice_execution", SpliceWork, Spliced)
PROVE_MOTION = Task("prove_motion", RequestWork[CertifyMotionRequest], ProvenMotion)
PROVE_GRIPPER = Task("prove_gripper", GripperWork, ProvenMotion)
PROVE_BESIDE = Task("prove_beside", BesideWork, BesideProof)
PROVE_TOGETHER = Task("prove_together", TogetherWork, ProvenMotion)
