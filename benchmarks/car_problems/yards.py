"""Yards: random places with boxes in them that a car has to drive through."""

from dataclasses import dataclass

import numpy as np

import planning
from planning.domain.request.options import SearchOptions

JOINT = "car::base_joint"
# Half the sides of a yard [m]; a car that may not reverse needs a larger one. And the radius of the
# circle that holds the car, wherever it stands.
_HALF, _HALF_ONE_WAY = np.array([1.2, 0.9]), np.array([1.8, 1.5])
_ROOM = 0.32


@dataclass(frozen=True)
class CarProblem:
    """One problem.

    Attributes:
        name: For tables.
        world: With the car at its start.
        goal: Where it shall be.
        search: Says what it can drive.
    """

    name: str
    world: planning.World
    goal: planning.ConfigurationGoal | planning.JointGoal
    search: SearchOptions

    def problem(self, seed: int, **options: object) -> planning.PlanningProblem:
        """Return what is asked, with a seed for the search and options of other stages."""
        return planning.PlanningProblem("car", self.goal, search=self.search, seed=seed, **options)  # pyright: ignore[reportArgumentType]


def one_way(radius: float = 0.3) -> SearchOptions:
    """Return the search for a car that may not reverse."""
    return SearchOptions(spaces={JOINT: planning.Steering(radius, reverse=False)})


def yard(seed: int, *, reverse: bool, num_boxes: int = 6) -> CarProblem:
    """Return a yard with walls around it and boxes in it; start and goal are beside all of them."""
    rng, half = np.random.default_rng(seed), _HALF if reverse else _HALF_ONE_WAY
    ends: list[np.ndarray] = []
    while len(ends) < 2:
        spot = rng.uniform(-1, 1, 2) * (half - _ROOM)
        if all(np.hypot(*(spot - end[:2])) > 1.0 for end in ends):
            ends.append(np.array([*spot, rng.uniform(-np.pi, np.pi)]))
    boxes: list[str] = []
    while len(boxes) < num_boxes:
        spot, sides = rng.uniform(-1, 1, 2) * half, rng.uniform(0.08, 0.3, 2)
        yaw = rng.uniform(0, np.pi)
        clear = np.hypot(*sides) / 2 + _ROOM
        if all(np.hypot(*(spot - end[:2])) > clear for end in ends):
            boxes.append(_box(f"box{len(boxes)}", sides, spot, yaw))
    for k, (x, y) in enumerate(((1, 0), (-1, 0), (0, 1), (0, -1))):
        sides = np.array([0.04, 2 * half[1]]) if x else np.array([2 * half[0], 0.04])
        boxes.append(_box(f"wall{k}", sides, np.array([x, y]) * (half + 0.02), 0.0))
    start = ", ".join(f"{number:.4f}" for number in ends[0])
    lines = [
        f"robots: [{{name: car, model: car, positions: [{start}]}}]",
        "objects:",
        *boxes,
    ]
    world = planning.load_world(planning.parse_scene("\n".join(lines)))
    search = SearchOptions() if reverse else one_way()
    ways = "both ways" if reverse else "one way"
    return CarProblem(f"yard {seed}, {ways}", world, planning.JointGoal(ends[1][None]), search)


def parking(configuration: str, *, reverse: bool) -> CarProblem:
    """Return the bundled scene with one of its configurations as the goal."""
    path = planning.bundled_folder("scenes") / "parallel_parking.scene.yaml"
    world = planning.load_world(planning.read_scene(path))
    search = SearchOptions() if reverse else one_way()
    ways = "both ways" if reverse else "one way"
    goal = planning.ConfigurationGoal(configuration)
    return CarProblem(f"{configuration}, {ways}", world, goal, search)


def _box(name: str, sides: np.ndarray, spot: np.ndarray, yaw: float) -> str:
    size = f"[{sides[0]:.4f}, {sides[1]:.4f}, 0.1]"
    position = f"[{spot[0]:.4f}, {spot[1]:.4f}, 0.05]"
    turn = f"[{np.cos(yaw / 2):.6f}, 0, 0, {np.sin(yaw / 2):.6f}]"
    pose = f"{{position: {position}, quaternion: {turn}}}"
    return f"  - {{name: {name}, shape: {{box: {size}}}, pose: {pose}}}"
