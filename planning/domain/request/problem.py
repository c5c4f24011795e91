"""PlanningProblem: everything that decides a plan, but for the world."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from planning.domain.goals.goal import Goal
from planning.domain.planner.regions import Regions
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.options import (
    CertifyOptions,
    IkOptions,
    RefineOptions,
    RetimeOptions,
    SearchOptions,
)
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PlanningProblem(Value):
    """Move a group from a start to a goal.

    Attributes:
        group: `robot` or `robot::group`.
        goal: What to reach.
        start: The group's q, shape (nq,); None for the scene's current state.
        ik: Options of the goals stage.
        search: Options of the search stage.
        refine: Options of the refine stage.
        retime: Options of the retime stage.
        margin: Distance that everything keeps [m]; None for the scene's.
        seed: Of all randomness.
        constraints: What the motion shall keep on its whole way, all of them.
        certify: What to find out about the motion once it is proven.
        regions: Where the planner "GCS" looks for a path; the others do not.
    """

    group: str
    goal: Goal
    start: Float64[np.ndarray, " nq"] | None = None
    ik: IkOptions = field(default_factory=IkOptions)
    search: SearchOptions = field(default_factory=SearchOptions)
    refine: RefineOptions = field(default_factory=RefineOptions)
    retime: RetimeOptions = field(default_factory=RetimeOptions)
    margin: float | None = None
    seed: int = 0
    constraints: tuple[PathConstraint, ...] = ()
    certify: CertifyOptions = field(default_factory=CertifyOptions)
    regions: Regions | None = None
