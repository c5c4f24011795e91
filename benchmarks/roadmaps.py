"""Roadmaps that are reused: the first query, those after it, and RRTConnect, in ratios.

    python -m benchmarks.roadmaps [--states 2000] [--starts 30]

From free configurations, drawn by a seed, to frames of a scene. What a straight line answers is
left out: nobody is asked there.
"""

import argparse
import time
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

import planning
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.robot.manifold import Manifold

_SCENES = {
    "panda_shelf": ("panda", ("upper", "lower")),
    "ur5e_pickup": ("arm", ("pick", "place")),
}
_ALLOWED = 20.0
_EXACT = np.zeros(3)


@dataclass(frozen=True)
class Pair:
    """The same question to a roadmap that is there, and to RRTConnect."""

    mapped: MotionPlan
    plain: MotionPlan


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=2000)
    parser.add_argument("--starts", type=int, default=30)
    given = parser.parse_args()
    print("scene | queries | by roadmap | first [s] | second/first | /RRTConnect: time | length")
    for scene in _SCENES:
        print(" | ".join(_row(scene, planning.RoadmapOptions(given.states), given.starts)))


def _row(scene: str, options: planning.RoadmapOptions, count: int) -> list[str]:
    name, frames = _SCENES[scene]
    file = planning.bundled_folder("scenes") / f"{scene}.scene.yaml"
    world = planning.load_world(planning.read_scene(file))
    shelf = planning.RoadmapCache()
    pairs: list[Pair] = []
    first = 0.0
    for k, start in enumerate(_starts(world, name, count)):
        goal = planning.PoseGoal(
            (planning.PoseTarget(planning.Pose.identity(), frames[k % len(frames)]),),
            "",
            _EXACT,
            _EXACT,
        )
        problem = planning.PlanningProblem(
            name,
            goal,
            start=start,
            search=planning.SearchOptions(allowed_planning_time=_ALLOWED, roadmap=options),
            refine=planning.RefineOptions("none"),
            seed=k,
        )
        mapped = _plan(problem, world, shelf)
        first = first or mapped.timings["roadmap_build"]
        if mapped.stages.search.roadmap.reason != "straight_line":
            search = replace(problem.search, roadmap=None)
            pairs.append(Pair(mapped, _plan(replace(problem, search=search), world, shelf)))
    seconds = median(_seconds(pair.mapped) for pair in pairs)
    return [
        scene,
        str(len(pairs)),
        str(sum(pair.mapped.stages.search.roadmap.used for pair in pairs)),
        f"{first:.2f}",
        f"{seconds / (first + seconds):.3f}",
        f"{median(_seconds(p.mapped) / _seconds(p.plain) for p in pairs):.2f}",
        f"{median(_length(p.mapped) / _length(p.plain) for p in pairs):.2f}",
    ]


def _starts(world: planning.World, name: str, count: int) -> np.ndarray:
    """Return free configurations within half a turn of zero."""
    group = world.group(name)
    limits = world.limits(group)
    low, high = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    drawn = np.random.default_rng(5).uniform(low, high, (50 * count, group.num_positions))
    drawn = Manifold(group.joints).normalized(drawn)
    oracle = world.collision_oracle(group, world.margins(padding=0.001))
    return drawn[oracle.are_free(drawn)][:count]


def _plan(
    problem: planning.PlanningProblem, world: planning.World, shelf: planning.RoadmapCache
) -> MotionPlan:
    deadline = planning.Deadline.after(_ALLOWED, time.monotonic)
    return planning.plan(problem, world, deadline=deadline, roadmaps=shelf)


def _seconds(found: MotionPlan) -> float:
    """Return what the search took, without what was built once."""
    spent = ("search", "shortcut", "roadmap")
    seconds = sum(found.timings.get(stage, 0.0) for stage in spent)
    return seconds - found.timings.get("roadmap_build", 0.0)


def _length(found: MotionPlan) -> float:
    return found.stages.search.length


if __name__ == "__main__":
    main()
