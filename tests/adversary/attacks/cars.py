"""Attack on cars: slow, sideways, on the spot, and in small jumps, with the bundled car.

However slow it is, a car's way is along its own x axis, and it turns by no more than its way over
its turning radius.
"""

import time
from pathlib import Path

import numpy as np
import yaml

import planning
from tests.adversary.cases import PATIENCE, Document, Outcome
from tests.adversary.draws.motions import hermite, positions, sample_places

# How far it may slip, or turn beyond its way, on all of a motion [m and rad].
_NOTHING = 1e-4


def draw(rng: np.random.Generator, _: Path) -> Document:
    """Return a drive that is impossible, or nearly possible: a step, as slow as you like."""
    duration = float(10 ** rng.uniform(0, 10))
    step = rng.uniform(-1, 1, size=3) * [1, 1, 1] * (rng.random(3) < 0.6)
    if rng.random() < 0.3:
        step[1:] *= 10 ** rng.uniform(-7, -3)
    if rng.random() < 0.4:
        return _case(_hops(rng, step / 10))
    powers = hermite(duration, step, np.zeros((2, 3)), np.zeros((2, 3)))
    part = {"bases": [[0.0, 0.0, 0.0]], "coefficients": [powers.tolist()]}
    return _case({"breaks": [0.0, duration], "joints": {"base_joint": part}})


def _hops(rng: np.random.Generator, step: np.ndarray) -> Document:
    """Return a motion that stands, but for a hop between every two pieces."""
    count = int(10 ** rng.uniform(1, 4.5))
    size = np.abs(step).max()
    count = max(2, min(count, int(size / 0.99e-6)))
    hop = step / max(size, 1e-30) * 0.99e-6
    places = np.arange(count)[:, None] * hop
    width = float(10 ** rng.uniform(-6, -2))
    part = {"bases": places.tolist(), "coefficients": np.zeros((count, 1, 3)).tolist()}
    return {"breaks": (np.arange(count + 1) * width).tolist(), "joints": {"base_joint": part}}


def _case(motion: Document) -> Document:
    return {"kind": "cars", "questions": [{"motion": motion}]}


def judge(case: Document, _: Path) -> Outcome:
    """Ask, and add up how far it slips and how far it turns."""
    outcome = Outcome()
    (question,) = case["questions"]
    motion = question["motion"]
    world = planning.load_world(
        planning.parse_scene({"name": "s", "robots": [{"name": "r", "model": "car"}]})
    )
    part = motion["joints"]["base_joint"]
    arrays = (np.array(motion["breaks"]), np.array(part["bases"]), np.array(part["coefficients"]))
    curve = planning.TimedTrajectory(world.group("r").joints, *arrays)
    deadline = planning.Deadline.after(PATIENCE, time.process_time)
    certificate, _report = planning.certify_trajectory(world, "r", curve, deadline=deadline)
    outcome.count("asked")
    outcome.count("proven", certificate.proven)
    if not certificate.proven:
        return outcome
    card = yaml.safe_load((planning.bundled_folder("models") / "car" / "robot.yaml").read_text())
    radius = card["limits"]["base_joint"]["steering"]["turning_radius"]
    pieces, local, _ = sample_places(motion, 4000)
    x, y, yaw = positions(motion, pieces, local)["base_joint"].T
    way, across = np.diff(x), np.diff(y)
    heading = (yaw[1:] + yaw[:-1]) / 2
    along = way * np.cos(heading) + across * np.sin(heading)
    slip = float(np.abs(across * np.cos(heading) - way * np.sin(heading)).sum())
    length = float(np.abs(along).sum())
    turn = float(np.abs(np.diff(yaw)).sum())
    told = f"in {motion['breaks'][-1]:.4g} s, {len(part['bases'])} pieces, a way of {length:.4g} m"
    if slip > _NOTHING + 1e-4 * length:
        outcome.blame("slip of a car", f"{slip:.4g} m {told}", 13)
    if turn > _NOTHING + 1.001 * length / radius:
        outcome.blame("turn of a car", f"{turn:.4g} rad {told}", 13)
    return outcome
