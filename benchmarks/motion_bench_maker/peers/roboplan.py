"""Roboplan on the problems, with its default edge checks and with fine ones."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks.motion_bench_maker.limits import least_duration, peak_rate
from benchmarks.motion_bench_maker.peers.process import PeerLost, PeerProcess
from benchmarks.motion_bench_maker.problems import Obstacle, Problem
from benchmarks.motion_bench_maker.referee import Polynomials, Referee
from benchmarks.motion_bench_maker.robots import RobotFiles
from benchmarks.motion_bench_maker.runs import ALLOWED_SECONDS, GoalKind, Run

_WORKER = Path(__file__).with_name("roboplan_worker.py")
_INSTALL = (
    "`make bench-peers` installs roboplan into build/peers and runs this; or install the wheel "
    "`roboplan==0.7.0` into another environment, never this one, and name its interpreter with "
    "--peer-python FILE"
)
# Between two configurations of an edge that are checked [rad]: roboplan's default, and a tenth.
_DEFAULT_STEP, _FINE_STEP = 0.05, 0.005
_SEED = 0


@dataclass(frozen=True)
class RoboplanPeer:
    """Roboplan with one step of its edge checks.

    Attributes:
        name: Of its rows.
        process: That plans; several peers may share it.
        files: Of the robot.
        step: Between two configurations that it checks [rad].
        clock: By which its times are told; its 5 s are always of the wall.
    """

    name: str
    process: PeerProcess
    files: RobotFiles
    step: float
    clock: Literal["wall", "cpu"]

    def run(self, problem: Problem, goal: GoalKind, referee: Referee) -> Run:
        """Plan a problem and let the referee judge what is delivered."""
        pose = referee.goal_pose if goal == "pose" else None
        try:
            told = self.process.ask(question(self.files, problem, pose, self.step))
        except PeerLost as fault:
            return Run(problem, goal, 0.0, 0.0, failure="peer_lost", detail=str(fault))
        return judged(told, problem, goal, referee, self)


def roboplan_peers(
    stack: ExitStack, python: Path, files: RobotFiles, clock: Literal["wall", "cpu"]
) -> tuple[RoboplanPeer, ...]:
    """Start roboplan and return it with both settings.

    Args:
        stack: Ends it.
        python: The interpreter that has it.
        files: Of the robot.
        clock: By which its times are told.

    Raises:
        PeerMissing: It is not there.
    """
    # Not beside the package's folder, nor with this environment's paths (-I).
    process = stack.enter_context(PeerProcess([str(python), "-I", str(_WORKER)], _INSTALL))
    return (
        RoboplanPeer(process.name, process, files, _DEFAULT_STEP, clock),
        RoboplanPeer(f"{process.name}, fine", process, files, _FINE_STEP, clock),
    )


def question(
    files: RobotFiles, problem: Problem, pose: np.ndarray | None, step: float
) -> dict[str, Any]:
    """Return what the worker is asked; `pose` is X_WT of the tool, shape (4, 4), or None."""
    return {
        "urdf": str(files.urdf),
        "srdf": str(files.urdf.with_suffix(".srdf")),
        "root": files.root_link,
        "tool": files.spec.tool,
        "joints": problem.joints,
        "velocity": files.spec.velocity,
        "acceleration": files.spec.acceleration,
        "obstacles": [
            {"name": o.name, "kind": o.kind, "dims": o.dims, "pose": _pose(o).tolist()}
            for o in problem.obstacles
        ],
        "start": problem.start,
        "goal": problem.goal if pose is None else None,
        "pose": None if pose is None else pose.tolist(),
        "step": step,
        "seconds": ALLOWED_SECONDS,
        "seed": _SEED,
    }


def judged(
    told: dict[str, Any], problem: Problem, goal: GoalKind, referee: Referee, peer: RoboplanPeer
) -> Run:
    """Return a run with what the referee finds of the setpoints that an answer has."""
    total, cpu = told[f"{peer.clock}_ms"], told["cpu_ms"]
    if told["fault"]:
        return Run(problem, goal, total, cpu, failure="not_solved", detail=told["fault"])
    times, positions, velocities = (
        np.array(told[name]) for name in ("times", "positions", "velocities")
    )
    motion = Polynomials.through(problem.joints, times, positions, velocities)
    samples = motion.samples()
    velocity, acceleration = np.array(peer.files.spec.velocity), peer.files.spec.acceleration
    return Run(
        problem,
        goal,
        total,
        cpu,
        length=float(np.linalg.norm(np.diff(samples, axis=0), axis=1).sum()),
        duration=float(times[-1] - times[0]),
        free=referee.is_free(motion) and referee.is_from_start_to_goal(motion, pose=goal == "pose"),
        lower_bound=least_duration(samples[-1] - samples[0], velocity, np.array(acceleration)),
        peak_rate=peak_rate(motion, velocity, np.array(acceleration)),
    )


def _pose(thing: Obstacle) -> np.ndarray:
    """Return X_WO."""
    w, x, y, z = np.array(thing.quaternion) / np.linalg.norm(thing.quaternion)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = thing.position
    return pose
