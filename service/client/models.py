"""What a server answers, as far as the client knows it; members that are new are kept.

The OpenAPI document says what each member means. The models name what clients of this package use;
what a newer server tells besides is there too, as it came.
"""

from datetime import datetime
from typing import Any

from pydantic import BaseModel, ConfigDict


class Answer(BaseModel):
    """An answer, or a part of one."""

    model_config = ConfigDict(extra="allow", frozen=True)


class Problem(Answer):
    """Why a request was refused."""

    title: str
    status: int
    code: str
    detail: str
    evidence: dict[str, Any]


class Failure(Answer):
    """Why a job has no result."""

    code: str
    stage: str
    detail: str
    evidence: dict[str, Any]
    timings: dict[str, float] = {}


class Joint(Answer):
    """A joint of a group."""

    name: str
    type: str


class Group(Answer):
    """A group of a scene."""

    name: str
    aliases: list[str]
    joints: list[Joint]
    configurations: dict[str, list[float]]


class Model(Answer):
    """What a robot can do."""

    name: str
    groups: list[Group]


class Scene(Answer):
    """A scene at a revision."""

    id: str
    revision: int
    name: str
    digest: str
    bodies: list[str]
    frames: list[str]
    groups: list[Group]
    num_pairs: int


class Funnel(Answer):
    """How many samples survived what."""

    tried: int
    converged: int
    within_limits: int
    collision_free: int
    distinct: int


class GoalsReport(Answer):
    """What the goals stage found."""

    funnel: Funnel


class SearchReport(Answer):
    """What the search stage did."""

    planner: str
    num_states_checked: int
    length: float


class RefineReport(Answer):
    """What the refine stage did."""

    method: str
    improved: bool
    reason: str


class RetimeReport(Answer):
    """What the retime stage did."""

    method: str
    duration: float


class Stages(Answer):
    """One report per stage."""

    goals: GoalsReport
    search: SearchReport
    refine: RefineReport
    retime: RetimeReport


class Check(Answer):
    """One check of a certificate."""

    name: str
    passed: bool


class Certificate(Answer):
    """What is proven of a motion."""

    proven: bool
    min_clearance: float | None
    pair: tuple[str, str]
    time: float
    checks: list[Check]


class Trajectory(Answer):
    """A motion."""

    duration: float


class PlanResult(Answer):
    """What came of a plan."""

    digest: str
    trajectory: Trajectory
    certificate: Certificate
    stages: Stages


class Job(Answer):
    """What plans and executions have in common."""

    id: str
    state: str
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    failure: Failure | None
    timings: dict[str, float] = {}
    unrecorded: list[str] = []


class Plan(Job):
    """A plan; poll it until it has ended."""

    stage: str
    progress: float
    digest: str | None = None
    result: PlanResult | None = None


class ExecutionStatus(Answer):
    """How far an execution is."""

    state: str
    progress: float
    time: float
    positions: list[float]
    tracking_error: float
    max_tracking_error: float


class Execution(Job):
    """An execution of a plan; poll it until it has ended."""

    group: str
    status: ExecutionStatus | None
