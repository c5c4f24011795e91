"""The task that looks for contacts of robots which are moved by different executions."""

from service.jobs.task import Task, TaskModel
from service.scenes.tasks import SceneWork


class MeasuredGroup(TaskModel):
    """Where an execution has measured its group.

    Attributes:
        execution: Its id.
        group: That it moves.
        positions: Measured [rad or m].
    """

    execution: str
    group: str
    positions: list[float]


class TouchWork(SceneWork):
    """Measured positions of several executions in one scene."""

    groups: list[MeasuredGroup]


class Touching(TaskModel):
    """A contact of robots that two executions move.

    Attributes:
        executions: Ids of both.
        pair: Full names of the bodies.
        depth: By which they overlap [m].
    """

    executions: tuple[str, str]
    pair: tuple[str, str]
    depth: float


class Touches(TaskModel):
    """Contacts, the deepest first."""

    found: list[Touching]


TOUCHING = Task("touching_robots", TouchWork, Touches)
