"""What every worker does first, so that its first job is as quick as the next."""

import time

import numpy as np

from planning import (
    Deadline,
    JointGoal,
    ModelLibrary,
    PlanningProblem,
    load_world,
    parse_scene,
    plan,
)
from service.jobs.context import TaskContext
from service.plans.tasks import WARM_UP, NoWork, WarmedUp

_SCENE = "{name: warm-up, robots: [{name: body, model: planar_l, positions: [0, 0, 0]}]}"
_GOAL = JointGoal(np.array([[0.2, 0.1, 0.3]]))
# It takes 40 ms; a busy machine may need longer [s].
_ALLOWED = 60.0


@WARM_UP.runs
def warm_up(_: NoWork, context: TaskContext) -> WarmedUp:
    """Plan a motion, certificate included: whatever cannot be imported or run shows now.

    Raises:
        WayproofError: There is no motion, which means that this installation is broken.
    """
    world = load_world(parse_scene(_SCENE), ModelLibrary.bundled())
    problem = PlanningProblem("body", _GOAL, seed=1)
    deadline = Deadline.after(_ALLOWED, time.monotonic, context.is_canceled)
    found = plan(problem, world, deadline=deadline)
    return WarmedUp(proven=found.certificate.proven)
