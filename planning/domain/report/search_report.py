"""What the search stage says about its work."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class AttemptReport(Value):
    """What one attempt at a solution came to.

    Attributes:
        planner: OMPL's name.
        outcome: "solved", "collides" (on a closer look), "setup" if setting the planner up took
            longer than it may, or OMPL's word for how it ended. While a
            planner is at work on a path, "improving": its lengths and cost are all the planner's
            own measure, and the states are not counted yet.
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
            "blocked" (on a closer look), "interrupted" (the search ended while it was asked),
            "not_proven" (however closely it was looked at).
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
        attempts: How many were made: none where a straight line was free or a roadmap knew a way.
        solved: How many of them found an exact solution.
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
        interpolated: Whether the path has as many waypoints as were asked for; if not, there was
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
