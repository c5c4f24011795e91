"""Unavailable planners: planners of OMPL that its Python wheel does not bind.

CoppeliaSim offers these. Each has its closest available planner, and how the two are related.
"""

from collections.abc import Iterable

from planning.errors import UnknownName

# By name: the closest available planner, and the rest of a sentence about it.
CLOSEST_PLANNERS = {
    "BiTRRT": ("AORRTC", "also grows two trees, and prefers cheap paths"),
    "CForest": ("InformedRRTstar", "runs one of the trees that CForest runs side by side"),
    "EST": ("KPIECE1", "also grows its tree where it has explored least"),
    "LazyPRM": ("PRM", "builds the same roadmap and checks its edges at once"),
    "LazyPRMstar": ("PRMstar", "builds the same roadmap and checks its edges at once"),
    "LazyRRT": ("LBKPIECE1", "is the available planner that checks the edges of its trees late"),
    "LBTRRT": ("RRTstar", "also improves its tree toward the shortest path"),
    "PDST": ("KPIECE1", "also divides a projection into cells and grows where they are emptiest"),
    "pRRT": ("RRT", "grows the same tree on one thread, so that the same seed gives the same path"),
    "pSBL": ("LBKPIECE1", "also grows two trees by cells and checks edges late, on one thread"),
    "SBL": ("LBKPIECE1", "also grows two trees by cells and checks edges late"),
    "SPARS": ("PRM", "builds a roadmap too, without thinning it"),
    "SPARStwo": ("PRM", "builds a roadmap too, without thinning it"),
    "STRIDE": ("KPIECE1", "also samples where its tree is thin"),
    "TRRT": ("RRTstar", "also prefers cheap paths"),
}


def unknown_planner(name: str, known: Iterable[str]) -> UnknownName:
    """Return the error for an unknown planner, with similar names or the closest available one."""
    names = sorted(known)
    # Papers write RRT* where OMPL writes RRTstar.
    starred = name.replace("*", "star")
    foreign = next((other for other in CLOSEST_PLANNERS if other.lower() == starred.lower()), None)
    if foreign is None or CLOSEST_PLANNERS[foreign][0] not in names:
        is_misspelled = starred != name and starred in names
        return (
            _misspelled_planner(name, starred, names)
            if is_misspelled
            else UnknownName.among("planner", name, names)
        )
    nearest, relation = CLOSEST_PLANNERS[foreign]
    message = (
        f"planner {name!r} is OMPL's, but OMPL's Python wheel does not bind it as a geometric "
        f"planner; the closest available one is {nearest!r}, which {relation}; planners: {names}"
    )
    evidence = {
        "kind": "planner",
        "name": name,
        "known": names,
        "nearest": [nearest],
        "reason": f"{nearest} {relation}",
    }
    return UnknownName(message, evidence)


def _misspelled_planner(name: str, correct_name: str, names: list[str]) -> UnknownName:
    message = f"planner {name!r} does not exist; did you mean {correct_name!r}? planners: {names}"
    evidence = {"kind": "planner", "name": name, "known": names, "nearest": [correct_name]}
    return UnknownName(message, evidence)
