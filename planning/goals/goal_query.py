"""GoalQuery: input of the goals stage: group, goal, start, margins, options and constraints."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.goals.goal import Goal
from planning.domain.request.options import IkOptions
from planning.domain.robot.joints import JointGroup
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints


@dataclass(frozen=True)
class GoalQuery:
    """Input of the goals stage.

    Attributes:
        group: Joint group of the configurations.
        goal: Goal that they reach.
        start: Start configuration, shape (nq,); results are ordered by the distance from it.
        margins: Required distance of every body pair [m].
        options: Limits of the search: trials, number of configurations, time.
        num_measured: Number of colliding solutions whose colliding pairs and depths are measured.
            That takes longer than finding the solutions: plans use few.
        constraints: Path constraints that configurations of a tool goal satisfy; None for none.
        kept: Coordinates that configurations of a tool goal have as the start has them, shape
            (nq,); None for none.
    """

    group: JointGroup
    goal: Goal
    start: Float64[np.ndarray, " nq"]
    margins: PairMargins
    options: IkOptions
    num_measured: int = 5
    constraints: PathConstraints | None = None
    kept: Bool[np.ndarray, " nq"] | None = None
