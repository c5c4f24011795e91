"""Draw scenes with a motion in each: `benchmarks/seed_pictures.py [--folder docs/images]`.

A PNG per scene: as the motion finds it, what moves at some instants of it (paler the earlier), the
way of its tool frame, and for a distance band the segments to the nearest wall.
"""

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import Role

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import planning  # noqa: E402
from benchmarks.seed_scenes.canvas import Array, Canvas  # noqa: E402
from benchmarks.seed_scenes.leg import Leg  # noqa: E402
from benchmarks.seed_scenes.meshes import triangles  # noqa: E402
from benchmarks.seed_scenes.seeds import PICTURES  # noqa: E402

_TRACE = np.array([0.85, 0.1, 0.45])
_SEGMENT = np.array([0.1, 0.35, 0.9])
_GRAY = np.array([0.7, 0.7, 0.7])


@dataclass(frozen=True)
class View:
    """From where to look at a scene, and what not to draw of it.

    Attributes:
        eye: Direction to the viewer.
        middle: What the picture shows in its middle [m].
        width: Of what it shows [m].
        hidden: Objects that would hide the others.
        ghosts: How many instants of every motion to draw.
        segments: How many segments to the nearest thing to draw along the way.
    """

    eye: tuple[float, float, float]
    middle: tuple[float, float, float]
    width: float
    hidden: tuple[str, ...] = ()
    ghosts: int = 2
    segments: int = 0


_WINDOW = ("south", "north", "ceiling")
VIEWS = {
    "maze_2d": View((0, 0, 1), (0, 0, 0), 1.7, ghosts=14),
    "maze_2d_band": View((0, 0, 1), (0, 0, 0), 1.7, ghosts=12, segments=120),
    "window_3d": View((0.5, -1.0, 0.6), (0, 0, 0.48), 2.3, _WINDOW, ghosts=9),
    "ur5e_pickup": View((0.9, 0.8, 0.55), (0.25, 0.1, 0.33), 1.7, ghosts=3),
    "parallel_parking": View((0, 0, 1), (0, -0.05, 0), 2.7, ghosts=9),
    "irb120_cell": View((1.0, 0.55, 0.6), (0.25, 0.0, 0.3), 1.6, ghosts=2),
}


def main() -> None:
    """Draw and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "docs" / "images")
    parser.add_argument("--only", nargs="+", choices=list(VIEWS), default=list(VIEWS))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for seed in PICTURES:
        if seed.name in options.only:
            scene = planning.bundled_folder("scenes") / f"{seed.scene}.scene.yaml"
            world = planning.load_world(planning.read_scene(scene))
            deadline = planning.Deadline.after(60.0, time.monotonic)
            picture = draw(seed.run(world, 0, deadline), VIEWS[seed.name])
            (options.folder / f"{seed.name}.png").write_bytes(picture)


def draw(legs: tuple[Leg, ...], view: View) -> bytes:
    """Return a PNG of motions."""
    canvas = Canvas(np.array(view.eye, dtype=float), np.array(view.middle), view.width)
    last = len(legs) - 1
    for number, leg in enumerate(legs):
        world, motion = leg.world, leg.plan.trajectory
        states = world.embed(leg.plan.group, motion.positions(motion.sample_times(0.005)))
        instants = np.linspace(0, len(states) - 1, view.ghosts).round().astype(int)
        shown = instants if number == 0 else instants[1:]
        for i in shown:
            age = (number + i / len(states)) / (last + 1)
            is_first = number == 0 and i == 0
            _draw_bodies(canvas, world, states[i], age, hidden=view.hidden, still=is_first)
        tool = world.frame_poses(leg.plan.group.tool_frames[0], states)
        canvas.dot(tool[:, :3, 3] + 0.002 * np.array(view.eye), _TRACE)
        _draw_segments(canvas, world, states, view)
    return canvas.png()


def _draw_bodies(
    canvas: Canvas,
    world: planning.World,
    state: Array,
    age: float,
    *,
    hidden: tuple[str, ...],
    still: bool,
) -> None:
    """Draw what moves, paler the smaller `age` (0 to 1) is, and with `still` the rest as well."""
    plant, graph = world.drake.plant, world.drake.scene_graph
    inspector = graph.model_inspector()
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    pale = 0.75 * (1 - age) ** 1.5
    for index, name in world.drake.body_names.items():
        frame_id = plant.GetBodyFrameIdIfExists(index)
        is_fixed = index in fixed
        if frame_id is None or name in hidden or (is_fixed and not still):
            continue
        x_wb = world.frame_poses(name, state[None])[0]
        for geometry in inspector.GetGeometries(frame_id, Role.kIllustration):
            x_wg = x_wb @ inspector.GetPoseInFrame(geometry).GetAsMatrix4()
            mesh = triangles(inspector.GetShape(geometry)) @ x_wg[:3, :3].T + x_wg[:3, 3]
            color = _color(inspector.GetIllustrationProperties(geometry))
            canvas.draw(mesh, color if is_fixed else color + pale * (1 - color))


def _draw_segments(canvas: Canvas, world: planning.World, states: Array, view: View) -> None:
    """Draw the shortest way to the nearest thing at some states, above everything else."""
    probe = world.distance_probe(world.margins())
    for i in np.linspace(0, len(states) - 1, view.segments).round().astype(int):
        a, b = probe.pairs_within(states[i], 1.0)[0].points
        line = a + np.linspace(0.0, 1.0, 60)[:, None] * (b - a)
        canvas.dot(line + 0.1 * np.array(view.eye), _SEGMENT, radius=1)


def _color(properties: object) -> Array:
    if properties is None or not properties.HasProperty("phong", "diffuse"):
        return _GRAY
    rgba = properties.GetProperty("phong", "diffuse")
    return np.array([rgba.r(), rgba.g(), rgba.b()])


if __name__ == "__main__":
    main()
