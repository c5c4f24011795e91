"""SearchReport: statistics of the search stage, its attempts, regions and roadmap."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class AttemptReport(Value):
    """Outcome and statistics of one planner attempt.

    Attributes:
        planner: OMPL's name.
        outcome: "solved", "collides" (at a finer resolution), "setup" if setting the planner up
            took longer than its limit, or OMPL's word for the planner's termination. While a
            planner is at work on a path, "improving": its lengths and cost are all the planner's
            own measure, and the states are not counted yet.
        raw_length: Length of its solution before shortcutting; 0 without one.
        length: Length after shortcutting.
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
    """Use of convex regions in a search.

    Attributes:
        digest: Of the regions: the same ones and the same request give the same motion.
        num_regions: Number of regions.
        considered: Rows of the regions in which the path was searched.
        is_inside: Whether the final path came from them.
        fallback: Why it did not, or "".
    """

    digest: str
    num_regions: int
    considered: tuple[int, ...]
    is_inside: bool
    fallback: str = ""


@dataclass(frozen=True, eq=False)
class RoadmapReport(Value):
    """Use of a roadmap in a search; the same whether it was built for the plan or loaded.

    Attributes:
        digest: Of its content.
        num_states: Its configurations.
        num_edges: Its free edges.
        num_states_checked: Configurations checked for collision to build it, at any time.
        used: Whether the final path came from it.
        reason: Why not, or "": "straight_line", "start_not_joined", "goal_not_joined", "no_way",
            "blocked" (at a finer resolution), "interrupted" (the search ended during the query),
            "not_proven" (at any resolution).
    """

    digest: str
    num_states: int
    num_edges: int
    num_states_checked: int
    used: bool
    reason: str = ""


@dataclass(frozen=True, eq=False)
class SearchReport(Value):
    """Statistics of the search stage.

    Attributes:
        planner: OMPL's name; of several, that of the final solution; "roadmap" for a roadmap's.
        attempts: Number of attempts: none where a straight line was free or a roadmap had a path.
        solved: Number of attempts with an exact solution.
        num_states_checked: Configurations checked for collision, shortcutting included.
        num_motions_checked: Edges checked.
        raw_length: Length of the final solution before shortcutting.
        length: Length after shortcutting.
        num_waypoints: Of the delivered path.
        resolution: Resolution of edge checks.
        padding: Distance that the search kept beyond the margin [m].
        direct: Whether a straight line was free, so that no planner ran.
        objective: Path cost that compared solutions.
        cost: Of the final solution, by the objective.
        attempts_log: One entry per attempt, the first ones if there are very many.
        was_canceled: Whether a cancel ended the search before all attempts were made.
        regions: Use of convex regions, if the planner is "GCS".
        roadmap: Use of a roadmap, if one was requested.
        interpolated: Whether the path has the requested number of waypoints; if not, there was
            no time for it.
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
    interpolated: bool = True
