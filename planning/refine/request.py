"""RefineRequest: input of the refinement stage."""

from dataclasses import dataclass, field, replace

from planning.domain.curves.path import JointPath
from planning.domain.request.motion_limits import MotionLimits
from planning.domain.request.options import RefineOptions
from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value
from planning.world.collision.margins import PairMargins
from planning.world.constraints.path_constraints import PathConstraints


@dataclass(frozen=True, eq=False)
class RefineRequest(Value):
    """Path to refine, with its limits, margins and constraints.

    Attributes:
        path: Free, at the search's resolution.
        limits: Joint limits, scaled as for the retimer.
        margins: Least distances between bodies.
        options: Method, and clearance objective if there is one.
        limits_jerk: Whether the retimer will bound jerk, so that it counts here too.
        constraints: Path constraints, or None. Boxes, cones and bands count as distances, locked
            joints and tighter limits as limits; a predicate accepts or rejects a curve as a whole.
        motion_limits: The retimer's other limits (loads), which count here too.
        fixed_coordinates: Coordinates of v that keep their start values.
    """

    path: JointPath
    limits: JointLimits
    margins: PairMargins
    options: RefineOptions
    limits_jerk: bool = False
    constraints: PathConstraints | None = None
    motion_limits: MotionLimits = field(default_factory=MotionLimits)
    fixed_coordinates: tuple[int, ...] = ()

    @property
    def straight(self) -> "RefineRequest":
        """The same request for the straight path between the path's ends, free or not."""
        return replace(self, path=self.path.straight)
