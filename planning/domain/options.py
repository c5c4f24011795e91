"""Options of the stages, with their defaults; each stage reads its own and no other."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class IkOptions(Value):
    """How hard to look for goal configurations.

    Attributes:
        max_configurations: Stop at this many distinct free ones.
        max_trials: Stop after this many seeds of the solver, over all targets.
    """

    max_configurations: int = 100
    max_trials: int = 300


@dataclass(frozen=True, eq=False)
class SearchOptions(Value):
    """How to search for a path.

    Attributes:
        planner: OMPL's name of the planner.
        parameters: OMPL's names and values of the planner's parameters.
        attempts: How many solutions to look for; the shortest is kept.
        allowed_planning_time: For the whole plan, all stages [s].
        resolution: Largest distance between two checked states of a motion (joint-space length:
            radians and metres weigh the same).
        num_states: If given, the path is interpolated to at least this many waypoints.
    """

    planner: str = "RRTConnect"
    parameters: Mapping[str, str | float | int | bool] = field(default_factory=dict)
    attempts: int = 1
    allowed_planning_time: float = 5.0
    resolution: float = 0.05
    num_states: int | None = None


@dataclass(frozen=True, eq=False)
class RefineOptions(Value):
    """Whether and how to optimise the path.

    Attributes:
        method: "trajopt"; "auto", which optimises only where the time left allows for it; or
            "none".
    """

    method: Literal["none", "trajopt", "auto"] = "trajopt"


@dataclass(frozen=True, eq=False)
class RetimeOptions(Value):
    """How to time the path.

    Attributes:
        method: "toppra" (velocity, acceleration) or "ruckig" (and jerk).
        velocity_scale: Factor on every velocity limit, in (0, 1].
        acceleration_scale: Factor on every acceleration and jerk limit, in (0, 1].
        sample_period: Of the delivered samples [s].
    """

    method: Literal["toppra", "ruckig"] = "toppra"
    velocity_scale: float = 1.0
    acceleration_scale: float = 1.0
    sample_period: float = 0.01
