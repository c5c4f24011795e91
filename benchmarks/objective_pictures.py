"""Draw one motion under each objective of refinement: `benchmarks/objective_pictures.py`.

A PNG with a column per objective: positions, velocities, accelerations and torques of the joints
over time, and the path of the tool from above and from the side. It also prints a row per objective
of what the report says.
"""

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import planning  # noqa: E402
from planning.domain.arrays import Array  # noqa: E402
from planning.world.mechanics.dynamics import GroupDynamics  # noqa: E402
from planning.world.mechanics.tool_kinematics import ToolKinematics  # noqa: E402

SCENE, GROUP, FRAME = "irb120_cell", "arm", "arm::tool0"
START = np.array([-1.5, 0.6, 0.2, 0.0, 0.7, 0.0])
OBJECTIVES = {
    "duration": planning.RefineObjective(duration=1.0),
    "smoothness, 2 s at most": planning.RefineObjective(smoothness=1.0, max_duration=2.0),
    "energy, 2 s at most": planning.RefineObjective(energy=1.0, max_duration=2.0),
    "path_length": planning.RefineObjective(path_length=1.0),
    "duration 1, smoothness 0.05": planning.RefineObjective(duration=1.0, smoothness=0.05),
}
_ROWS = (
    "positions [rad]",
    "velocities [rad/s]",
    "accelerations [rad/s²]",
    "torques [N m]",
    "tool from above: y over x [m]",
    "tool from the side: z over x [m]",
)
# Ample on a busy machine: what a deadline cuts differs from run to run.
_SECONDS = 200.0
_NUM_SAMPLES = 400
_SIZE, _DPI = (16.0, 15.0), 70


@dataclass(frozen=True)
class Drawn:
    """One motion, sampled; arrays of joints have shape (n, nq).

    Attributes:
        times: [s], shape (n,).
        series: Positions, velocities, accelerations and torques.
        tool: Positions of the tool frame [m], shape (n, 3).
    """

    times: Array
    series: tuple[Array, ...]
    tool: Array


def main() -> None:
    """Plan, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--file", type=Path, default=ROOT / "docs" / "images" / "objectives.png")
    parser.add_argument("--method", choices=["trajopt", "drake"], default="trajopt")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    file = planning.bundled_folder("scenes") / f"{SCENE}.scene.yaml"
    world = planning.load_world(planning.read_scene(file))
    motions = {name: plan(world, options.method, goal) for name, goal in OBJECTIVES.items()}
    for name, motion in motions.items():
        report = motion.stages.refine
        print(f"{name}: refine {1e3 * motion.timings['refine']:.0f} ms, {report.after}")
    draw({name: sampled(world, motion) for name, motion in motions.items()}, options.file)


def plan(
    world: planning.World, method: Any, objective: planning.RefineObjective
) -> planning.MotionPlan:
    """Return the motion to the configuration "ready" that is optimized for an objective."""
    problem = planning.PlanningProblem(
        GROUP,
        planning.ConfigurationGoal("ready"),
        start=START,
        search=planning.SearchOptions(allowed_planning_time=_SECONDS),
        refine=planning.RefineOptions(method, objective=objective),
    )
    return planning.plan(problem, world, deadline=planning.Deadline.after(_SECONDS, time.monotonic))


def sampled(world: planning.World, motion: planning.MotionPlan) -> Drawn:
    """Return what is drawn of a motion."""
    curve, group = motion.trajectory, world.group(GROUP)
    times = np.linspace(0.0, curve.duration, _NUM_SAMPLES)
    q, v, vdot = curve.positions(times), curve.velocities(times), curve.accelerations(times)
    torques = GroupDynamics(world, group).efforts(q, v, vdot)
    _, tool = ToolKinematics(world, group, FRAME).poses(q)
    return Drawn(times, (q, v, vdot, torques), tool)


def draw(motions: dict[str, Drawn], file: Path) -> None:
    """Write a PNG with a column per motion; the axes of a row are the same."""
    figure, axes = plt.subplots(
        len(_ROWS), len(motions), sharey="row", figsize=_SIZE, squeeze=False, layout="constrained"
    )
    longest = max(motion.times[-1] for motion in motions.values())
    for j, (name, motion) in enumerate(motions.items()):
        column: Any = axes[:, j]
        column[0].set_title(f"{name}\n{motion.times[-1]:.2f} s")
        for axis, values in zip(column, motion.series, strict=False):
            axis.plot(motion.times, values, linewidth=1.2)
            axis.set_xlim(0.0, longest)
        column[3].set_xlabel("time [s]")
        for axis, height in zip(column[4:], (1, 2), strict=True):
            axis.plot(motion.tool[:, 0], motion.tool[:, height], color="tab:purple")
            axis.plot(*motion.tool[0, [0, height]], "o", color="tab:green")
            axis.plot(*motion.tool[-1, [0, height]], "s", color="tab:red")
        column[4].set_aspect("equal", adjustable="datalim")
        for axis in column:
            axis.grid(alpha=0.3)
    for axis, label in zip(axes[:, 0], _ROWS, strict=True):
        axis.set_ylabel(label)
    joints = [f"joint {k + 1}" for k in range(len(START))]
    figure.legend(axes[0, 0].lines, joints, loc="outside lower center", ncols=len(joints))
    figure.savefig(file, dpi=_DPI)
    plt.close(figure)


if __name__ == "__main__":
    main()
