"""PlanningProblem: the complete planning request for one motion in a given world."""

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
    """Planning request: move a group from a start configuration to a goal.

    Attributes:
        group: `robot` or `robot::group`.
        goal: The goal.
        start: The group's q, shape (nq,); None for the scene's current state.
        ik: Options of the goals stage.
        search: Options of the search stage.
        refine: Options of the refine stage.
        retime: Options of the retime stage.
        margin: Collision margin: smallest distance between bodies [m]; None for the scene's.
        seed: Seed of all random numbers.
        constraints: Path constraints; all of them hold along the whole motion.
        certify: Options of the certify stage, for a motion once it is proven.
        regions: Convex free regions that the planner "GCS" plans in; other planners ignore them.
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
