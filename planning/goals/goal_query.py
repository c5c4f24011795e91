"""GoalQuery: what the goals stage is asked."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.goal import Goal
from planning.domain.request.options import IkOptions
from planning.domain.robot.joints import JointGroup
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints


@dataclass(frozen=True)
class GoalQuery:
    """What the stage is asked.

    Attributes:
        group: Whose configurations are wanted.
        goal: What they shall reach.
        start: The group's q, shape (nq,); nearness is measured from here.
        margins: The distances to keep.
        options: How hard to look.
        num_measured: Of so many of the solutions that collide it is measured with what, and how
            deep. That takes longer than finding them: plans do with few.
        rules: Path constraints that configurations which reach a pose shall keep; None for none.
    """

    group: JointGroup
    goal: Goal
    start: Float64[np.ndarray, " nq"]
    margins: PairMargins
    options: IkOptions
    num_measured: int = 2
    rules: PathConstraints | None = None
