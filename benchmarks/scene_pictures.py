"""Draw the bundled scenes, a motion in each: `benchmarks/scene_pictures.py [--folder docs/images]`.

A PNG per scene, `scene_<name>.png`, as reports draw them: the robot on its way, and the way of its
tool. No browser is needed, and the same versions give the same bytes.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import planning  # noqa: E402
from planning.world.replay.pictures.motion_pictures import Instant, motion_pictures  # noqa: E402

_SIZE = (480, 360)
# Where each motion goes: a group, and a frame or a configuration; of which instant of it, 0 to 1.
GOALS = {
    "ur5e_pickup": ("arm", "frame pick", 0.7),
    "panda_shelf": ("panda::arm", "frame upper", 0.8),
    "irb120_cell": ("arm", "frame pick", 1.0),
    "two_arms": ("left", "frame bolt_pick", 1.0),
    "maze_2d": ("body", "configuration exit", 0.45),
    "maze_2d_band": ("body", "configuration exit", 0.45),
    "window_3d": ("body", "configuration beyond", 0.5),
    "parallel_parking": ("car", "configuration parked", 0.6),
}


def main() -> None:
    """Plan, draw and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "docs" / "images")
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name in GOALS:
        begun = time.process_time()
        picture = draw(name)
        (folder / f"scene_{name}.png").write_bytes(picture)
        taken = time.process_time() - begun
        print(f"scene_{name}.png: {len(picture) // 1024} kB, {taken:.1f} s of CPU", flush=True)


def draw(name: str) -> bytes:
    """Return the picture of a bundled scene."""
    scene = planning.read_scene(planning.bundled_folder("scenes") / f"{name}.scene.yaml")
    world = planning.load_world(scene)
    group, goal, share = GOALS[name]
    search = planning.SearchOptions(allowed_planning_time=120.0)
    problem = planning.PlanningProblem(group, _goal(world, group, goal), search=search, seed=7)
    patience = planning.Deadline.after(240.0, time.monotonic)
    found = planning.plan(problem, world, deadline=patience)
    instant = Instant(share * found.trajectory.duration, (), np.empty((0, 3)))
    (picture,) = motion_pictures(world, world.group(group), found.trajectory, [instant], _SIZE)
    return picture


def _goal(
    world: planning.World, group: str, words: str
) -> planning.ConfigurationGoal | planning.PoseGoal:
    kind, name = words.split()
    if kind == "configuration":
        return planning.ConfigurationGoal(name)
    target = planning.PoseTarget(planning.Pose.identity(), frame=name)
    tool = world.group(group).tool_frames[0]
    return planning.PoseGoal((target,), tool, np.zeros(3), np.zeros(3))


if __name__ == "__main__":
    main()
