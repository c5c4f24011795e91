"""RefineRequest: what to refine."""

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
    """What to refine.

    Attributes:
        path: Free, at the search's resolution.
        limits: Scaled as they will be for the retimer.
        margins: Distances to keep.
        options: Whether to refine at all.
        jerk: Whether the retimer will bound jerk, so that it counts here too.
        rules: Path constraints, or None. Boxes, cones and bands count as distances do, locked
            joints and tighter limits as limits; a predicate accepts a curve or does not.
        others: What else the retimer will limit, so that it counts here too.
        held: Coordinates of v that stay as they are at the start.
    """

    path: JointPath
    limits: JointLimits
    margins: PairMargins
    options: RefineOptions
    jerk: bool = False
    rules: PathConstraints | None = None
    others: MotionLimits = field(default_factory=MotionLimits)
    held: tuple[int, ...] = ()

    @property
    def straight(self) -> "RefineRequest":
        """The same with the shortest way between the path's ends, free or not."""
        return replace(self, path=self.path.straight)
