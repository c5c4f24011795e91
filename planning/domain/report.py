"""Reports: what every stage says about its work."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.duration import DurationExplanation
from planning.domain.funnel import Funnel
from planning.domain.line import GoalLegs
from planning.domain.pose import Pose
from planning.domain.robustness import Robustness
from planning.domain.stop_report import StopReport
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class BodyPair(Value):
    """Two bodies and their signed distance.

    Attributes:
        bodies: Full names.
        distance: Signed [m]; negative is the depth of penetration.
        points: The nearest points in world, p_WA and p_WB, shape (2, 3) [m].
    """

    bodies: tuple[str, str]
    distance: float
    points: Float64[np.ndarray, "2 3"]


@dataclass(frozen=True, eq=False)
class NearestPose(Value):
    """The nearest pose that the tool frame can take, free and within limits, to what it cannot.

    Attributes:
        pose: X_WT, the tool frame in world.
        positions: The group's q there, shape (nq,).
        translation_error: From the nearest pose within the goal's tolerance [m].
        rotation_error: From the same [rad].
        pose_index: To which of the goal's poses it is the nearest.
        binding: What keeps it from being nearer: "limits", "collision", or "reach" if neither.
        joints: The coordinates at their limits, if limits bind.
        pairs: The pairs of bodies at their margins, if collisions bind.
    """

    pose: Pose
    positions: Float64[np.ndarray, " nq"]
    translation_error: float
    rotation_error: float
    pose_index: int
    binding: str
    joints: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()

    @property
    def evidence(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "position": self.pose.position.tolist(),
            "quaternion": self.pose.quaternion.tolist(),
            "positions": self.positions.tolist(),
            "translation_error": self.translation_error,
            "rotation_error": self.rotation_error,
            "pose_index": self.pose_index,
            "binding": self.binding,
            "joints": list(self.joints),
            "pairs": [list(pair) for pair in self.pairs],
        }


@dataclass(frozen=True, eq=False)
class GoalConfigurations(Value):
    """What the goals stage found.

    Attributes:
        positions: The group's q, nearest to the start first, shape (n, nq), n >= 1.
        target_indices: Which candidate of the goal each row reaches.
        funnel: How many samples survived what.
        legs: Approach and retreat of each row; none if the goal has neither.
    """

    positions: Float64[np.ndarray, "n nq"]
    target_indices: tuple[int, ...]
    funnel: Funnel
    legs: tuple[GoalLegs, ...] = ()

    @property
    def entries(self) -> Float64[np.ndarray, "n nq"]:
        """Where the free part of a motion to each row ends: at its approach, if it has one."""
        approaches = [leg.approach for leg in self.legs]
        if not approaches or approaches[0] is None:
            return self.positions
        return np.stack([leg.positions[0] for leg in approaches if leg is not None])


@dataclass(frozen=True, eq=False)
class AttemptReport(Value):
    """What one attempt at a solution came to.

    Attributes:
        planner: OMPL's name.
        outcome: "solved", "collides" (on a closer look), or OMPL's word for how it ended.
        raw_length: Of its solution before shortcutting; 0 without one.
        length: And after it.
        cost: By the objective; 0 without a solution.
        num_states_checked: Configurations checked for collision, shortcutting included.
    """

    planner: str
    outcome: str
    raw_length: float
    length: float
    cost: float
    num_states_checked: int


@dataclass(frozen=True, eq=False)
class RegionsReport(Value):
    """What regions were good for in a search.

    Attributes:
        digest: Of the regions: the same ones and the same request give the same motion.
        num_regions: How many there are.
        considered: Rows of those that the path was looked for in.
        is_inside: Whether the path that was kept came from them.
        fallback: Why it did not, or "".
    """

    digest: str
    num_regions: int
    considered: tuple[int, ...]
    is_inside: bool
    fallback: str = ""


@dataclass(frozen=True, eq=False)
class RoadmapReport(Value):
    """What a roadmap did for a plan; the same whether it was built for it or there already.

    Attributes:
        digest: Of its content.
        num_states: Its configurations.
        num_edges: The free ways between them.
        num_states_checked: Configurations checked for collision to build it, whenever that was.
        used: Whether the path that was kept is one of its.
        reason: Why not, or "": "straight_line", "start_not_joined", "goal_not_joined", "no_way",
            "blocked" (on a closer look), "not_proven" (however closely it was looked at).
    """

    digest: str
    num_states: int
    num_edges: int
    num_states_checked: int
    used: bool
    reason: str = ""


@dataclass(frozen=True, eq=False)
class SearchReport(Value):
    """What the search stage did.

    Attributes:
        planner: OMPL's name; of several, whose solution was kept; "roadmap" if it was a roadmap's.
        attempts: Solutions asked for.
        solved: Exact solutions found.
        num_states_checked: Configurations checked for collision, shortcutting included.
        num_motions_checked: Edges checked.
        raw_length: Length of the kept solution before shortcutting.
        length: And after it.
        num_waypoints: Of the delivered path.
        resolution: At which edges were checked.
        padding: Distance that was demanded beyond the margin [m].
        direct: Whether a straight line was free, so that no planner was asked.
        objective: By what solutions were compared.
        cost: Of the kept solution, by the objective.
        attempts_log: One entry per attempt, the first ones if there are very many.
        was_canceled: Whether a cancel ended the search before all attempts were made.
        regions: What regions were good for, if the planner is "GCS".
        roadmap: What a roadmap did, if one was asked for.
    """

    planner: str
    attempts: int
    solved: int
    num_states_checked: int
    num_motions_checked: int
    raw_length: float
    length: float
    num_waypoints: int
    resolution: float
    padding: float
    direct: bool = False
    objective: str = "length"
    cost: float = 0.0
    attempts_log: tuple[AttemptReport, ...] = ()
    was_canceled: bool = False
    regions: RegionsReport | None = None
    roadmap: RoadmapReport | None = None


@dataclass(frozen=True, eq=False)
class RefineReport(Value):
    """What the refine stage did.

    Attributes:
        method: "trajopt", "auto" or "none".
        improved: Whether the refined curve is what goes on.
        reason: Why not, or "".
        solver: Name of the solver, or "".
        rounds: Steps that were tried, each the solution of a convex program.
        length_before: Joint-space length of the path.
        length_after: Joint-space length of the refined curve.
        duration_before: Optimiser's estimate for its initial guess [s].
        duration_after: Optimiser's estimate for its solution [s].
        lower_bound: No motion between the two ends takes less, whatever its way [s].
    """

    method: str
    improved: bool
    reason: str = ""
    solver: str = ""
    rounds: int = 0
    length_before: float = 0.0
    length_after: float = 0.0
    duration_before: float = 0.0
    duration_after: float = 0.0
    lower_bound: float = 0.0


@dataclass(frozen=True, eq=False)
class RetimeReport(Value):
    """What the retime stage did.

    Attributes:
        method: "toppra" or "ruckig".
        duration: Of the trajectory [s].
        slowed: Factor by which the audit stretched the retimer's own answer (1 is not at all).
        binding: Name of the coordinate, frame or zone that is nearest its bound, per limit kind.
        utilisation: Peak over limit, per limit kind.
        stops: Instants of rest between start and goal.
        blend_deviation: How far corners were rounded (joint-space length); 0 for none.
        explanation: Why it takes that long, if that was asked for.
    """

    method: str
    duration: float
    slowed: float
    binding: dict[str, str] = field(default_factory=dict)
    utilisation: dict[str, float] = field(default_factory=dict)
    stops: int = 0
    blend_deviation: float = 0.0
    explanation: DurationExplanation | None = None


@dataclass(frozen=True, eq=False)
class CertifyReport(Value):
    """What the certify stage did.

    Attributes:
        intervals: Intervals on which clearance was bounded.
        distance_queries: Configurations at which distances were measured.
        candidates: How many candidate motions were looked at, this one included.
        refused: What was wrong with those before it, a line each.
        stop: How the motion can be stopped anywhere, if that was asked.
        robustness: How wrong world and robot may be, if that was asked.
    """

    intervals: int
    distance_queries: int
    candidates: int = 1
    refused: tuple[str, ...] = ()
    stop: StopReport | None = None
    robustness: Robustness | None = None
