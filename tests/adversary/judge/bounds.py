"""Constraints of every type: how each is drawn, built for the product, and judged from samples."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import planning
from planning.domain.arrays import Array
from tests.adversary.cases import Document
from tests.adversary.draws.motions import positions, sample_places
from tests.adversary.judge.distances import nearest
from tests.adversary.judge.kinematics import pose_matrix
from tests.adversary.judge.peaks import all_ranges
from tests.adversary.judge.surroundings import Look, Stage

_SAMPLES = 1500


@dataclass(frozen=True)
class Bound:
    """What there is to know of a type of constraint.

    Attributes:
        draw: Makes one that a motion keeps or breaks by an offset, a share of the size.
        excess: By how much a motion breaks it; negative where it keeps it.
        check: The name of its check.
        share: How much of the bound is rounding.
        unit: What "by far" is counted in.
    """

    draw: Callable[..., Document | None]
    excess: Callable[..., float]
    check: Callable[[Document], str]
    share: float = 0.0
    unit: Callable[..., float] = lambda stage, check: stage.size


def frame_poses(stage: Stage, motion: Document, frame: str, count: int = _SAMPLES) -> Any:
    """Return X_WF of a link during a motion, with the pieces and times."""
    pieces, local, times = sample_places(motion, count)
    placed = stage.robot.place(positions(motion, pieces, local), stage.base, len(times))
    return placed[frame.removeprefix("r::")], pieces, times


def build(entry: Document) -> Document:
    """Return the arguments of `certify_trajectory` that ask for a constraint."""
    if entry["type"] == "tool_limit":
        limit = planning.ToolLimit(entry["frame"], entry.get("speed"), entry.get("acceleration"))
        return {"options": planning.RetimeOptions(tool_limits=(limit,))}
    if entry["type"] == "speed_zone":
        zone = planning.SpeedZone("zone", entry["frame"], _box(entry), entry["speed"])
        return {"options": planning.RetimeOptions(speed_zones=(zone,))}
    return {"constraints": (_made(entry),)}


def _box(entry: Document) -> planning.PlacedBox:
    size = np.array([np.inf if x is None else x for x in entry["size"]])
    return planning.PlacedBox(size, planning.Pose.from_parts(entry["xyz"], rpy=entry["rpy"]))


def _made(entry: Document) -> Any:
    """Return the path constraint."""
    match entry["type"]:
        case "keep_in":
            return planning.KeepIn(entry["frame"], _box(entry))
        case "keep_out":
            return planning.KeepOut(entry["frame"], _box(entry))
        case "position":
            return planning.PositionBand(entry["frame"], _box(entry))
        case "orientation":
            along = (np.array(entry[name]) for name in ("axis", "direction"))
            return planning.OrientationCone(entry["frame"], *along, entry["tolerance"])
        case "distance_band":
            sides = (tuple(entry[name]) for name in ("bodies", "to"))
            top = np.inf if entry["max"] is None else entry["max"]
            return planning.DistanceBand(*sides, entry["min"], top)
        case "locked_joints":
            made: Any = planning.LockedJoints(tuple(entry["joints"]))
        case _:
            made = planning.TightLimits({k: tuple(v) for k, v in entry["limits"].items()})
    return made


def _frame(rng: np.random.Generator, stage: Stage) -> str:
    links = [joint.child for joint in stage.robot.joints]
    return "r::" + str(rng.choice(links))


def _in_box(stage: Stage, motion: Document, entry: Document) -> Array:
    """Return the origin of a frame in the axes of a box, shape (n, 3)."""
    poses, _, _ = frame_poses(stage, motion, entry["frame"])
    return _within(poses, entry)


def _within(poses: Array, entry: Document) -> Array:
    box = pose_matrix(entry["xyz"], entry["rpy"])
    return (poses[:, :3, 3] - box[:3, 3]) @ box[:3, :3]


def _draw_box(rng: np.random.Generator, stage: Stage, motion: Document) -> Document:
    frame = _frame(rng, stage)
    poses, _, _ = frame_poses(stage, motion, frame, 50)
    middle = poses[:, :3, 3].mean(axis=0) + 0.2 * stage.size * rng.normal(size=3)
    rpy = rng.uniform(-3, 3, size=3) * (rng.random() < 0.7)
    return {"frame": frame, "xyz": middle.tolist(), "rpy": rpy.tolist()}


def _draw_keep_in(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    entry = _draw_box(rng, stage, motion)
    reach = np.abs(_in_box(stage, motion, entry)).max(axis=0) * 2
    size = reach + 0.2 * stage.size
    tight = int(rng.integers(3))
    size[tight] = reach[tight] + 2 * off * stage.size
    return {**entry, "size": np.maximum(size, 1e-3 * stage.size).tolist()}


def _draw_band(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    entry = _draw_keep_in(rng, stage, motion, off)
    reach = np.abs(_in_box(stage, motion, entry)).max(axis=0) * 2
    tight = int(np.argmin(np.array(entry["size"]) - reach))
    free = [i for i in range(3) if i != tight and rng.random() < 0.7]
    entry["size"] = [None if i in free else x for i, x in enumerate(entry["size"])]
    return entry


def _excess_in(stage: Stage, motion: Document, entry: Document) -> float:
    half = np.array([np.inf if x is None else x / 2 for x in entry["size"]])
    return float((np.abs(_in_box(stage, motion, entry)) - half).max())


def _draw_keep_out(
    rng: np.random.Generator, stage: Stage, motion: Document, off: float
) -> Document:
    entry = _draw_box(rng, stage, motion)
    shape = rng.uniform(0.1, 1.0, size=3)
    nearest = float((np.abs(_in_box(stage, motion, entry)) / shape).max(axis=1).min())
    size = 2 * shape * max(nearest - off * stage.size, 1e-3 * stage.size)
    return {**entry, "size": size.tolist()}


def _excess_out(stage: Stage, motion: Document, entry: Document) -> float:
    half = np.array(entry["size"]) / 2
    return float(-(np.abs(_in_box(stage, motion, entry)) - half).max(axis=1).min())


def _draw_cone(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    axis, frame = rng.normal(size=3), _frame(rng, stage)
    poses, _, _ = frame_poses(stage, motion, frame, 50)
    direction = poses[0, :3, :3] @ axis + 0.3 * rng.normal(size=3)
    entry = {
        "frame": frame,
        "axis": axis.tolist(),
        "direction": direction.tolist(),
        "tolerance": 0.0,
    }
    # No cone is wider: what a motion leaves by more cannot be asked for.
    widest = min(_excess_cone(stage, motion, entry) + off, np.pi)
    return {**entry, "tolerance": max(widest, 1e-3)}


def _excess_cone(stage: Stage, motion: Document, entry: Document) -> float:
    poses, _, _ = frame_poses(stage, motion, entry["frame"])
    axis = poses[:, :3, :3] @ np.array(entry["axis"])
    direction = np.array(entry["direction"])
    across = np.linalg.norm(np.cross(axis, direction), axis=1)
    return float(np.arctan2(across, axis @ direction).max()) - entry["tolerance"]


def _draw_distance(
    rng: np.random.Generator, stage: Stage, motion: Document, off: float
) -> Document | None:
    bodies = stage.bodies
    if len(bodies) < 3:
        return None
    picked = [str(x) for x in rng.permutation(bodies)]
    entry: Document = {"bodies": picked[:1], "to": picked[1:], "min": 0.0, "max": None}
    low, high = _band(stage, motion, entry)
    if not np.isfinite(low):
        return entry
    if rng.random() < 0.5:
        entry["min"] = max(0.0, low - off * stage.size)
    else:
        entry["max"] = max(high + off * stage.size, 1e-3 * stage.size)
    return entry


def _band(stage: Stage, motion: Document, entry: Document) -> tuple[float, float]:
    """Return the smallest and the largest, over time, of the distance of two sets of bodies."""
    among = set(entry["to"])
    inside = {frozenset((a, b)) for a in stage.bodies for b in stage.bodies if {a, b} <= among}
    look = Look(skip=inside | stage.unchecked, only=frozenset(entry["bodies"]))
    seen = stage.worst(motion, look)
    if seen is None:
        return np.inf, np.inf
    highest = -np.inf
    pieces, local, _ = sample_places(motion, 40)
    q = positions(motion, pieces, local)
    solids = stage.solids(q, len(local))
    for i in range(len(local)):
        gaps = [
            near.distance
            for near in nearest(stage.pairs([s.at(i) for s in solids], look), stage.size)
        ]
        highest = max(highest, min(gaps))
    return seen.distance, highest


def _excess_distance(stage: Stage, motion: Document, entry: Document) -> float:
    low, high = _band(stage, motion, entry)
    above = -np.inf if entry["max"] is None else high - entry["max"]
    return -np.inf if not np.isfinite(low) else max(entry["min"] - low, above)


def _draw_locked(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    name = str(rng.choice([joint.name for joint in stage.robot.leaders]))
    part = motion["joints"][name]
    if rng.random() < 0.7:
        share = abs(off) * 1e-3
        part["bases"] = [part["bases"][0]] * len(part["bases"])
        part["coefficients"] = (np.array(part["coefficients"]) * share).tolist()
    return {"joints": [f"r::{name}"]}


def _excess_locked(stage: Stage, motion: Document, entry: Document) -> float:
    name = entry["joints"][0].removeprefix("r::")
    pieces, local, _ = sample_places(motion, 300)
    values = positions(motion, pieces, local)[name]
    return float(np.abs(values - values[0]).max())


def _draw_tight(
    rng: np.random.Generator, stage: Stage, motion: Document, off: float
) -> Document | None:
    ranges = {
        j.name: all_ranges(stage.robot, motion)[j.name]
        for j in stage.robot.leaders
        if j.kind == "revolute"
    }
    if not ranges:
        return None
    name = str(rng.choice(list(ranges)))
    low, high = ranges[name]
    return {"limits": {f"r::{name}": [low - abs(off) - 0.1, max(high + off, low + 1e-3)]}}


def _excess_tight(stage: Stage, motion: Document, entry: Document) -> float:
    ((name, (low, high)),) = entry["limits"].items()
    lowest, highest = all_ranges(stage.robot, motion)[name.removeprefix("r::")]
    return max(low - lowest, highest - high)


def _speeds(stage: Stage, motion: Document, frame: str, order: int) -> tuple[Array, Array]:
    """Return speeds or accelerations of a frame's origin by differences, and its poses."""
    step = 2e-4 * np.diff(motion["breaks"]).min()
    pieces, local, times = sample_places(motion, _SAMPLES)
    links = frame.removeprefix("r::")

    def place(shift: float) -> Array:
        q = positions(motion, pieces, local + shift * step)
        return stage.robot.place(q, stage.base, len(times))[links]

    if order == 1:
        outer = place(1)[:, :3, 3] - place(-1)[:, :3, 3], place(2)[:, :3, 3] - place(-2)[:, :3, 3]
        rates = (8 * outer[0] - outer[1]) / (12 * step)
    else:
        near = place(1)[:, :3, 3] + place(-1)[:, :3, 3], place(2)[:, :3, 3] + place(-2)[:, :3, 3]
        rates = (16 * near[0] - near[1] - 30 * place(0)[:, :3, 3]) / (12 * step**2)
    return np.linalg.norm(rates, axis=1), place(0)


def _draw_tool(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    frame = _frame(rng, stage)
    order = int(rng.integers(1, 3))
    top = float(_speeds(stage, motion, frame, order)[0].max())
    name = ("speed", "acceleration")[order - 1]
    return {"frame": frame, name: max(top * (1 + off), 1e-3)}


def _excess_tool(stage: Stage, motion: Document, entry: Document) -> float:
    order = 1 if "speed" in entry else 2
    top = float(_speeds(stage, motion, entry["frame"], order)[0].max())
    return top - entry["speed" if order == 1 else "acceleration"]


def _draw_zone(rng: np.random.Generator, stage: Stage, motion: Document, off: float) -> Document:
    entry = {
        **_draw_box(rng, stage, motion),
        "size": (stage.size * rng.uniform(0.1, 1, size=3)).tolist(),
    }
    return {
        **entry,
        "speed": max((_fastest_in(stage, motion, entry)) * (1 + off), 1e-3 * stage.size),
    }


def _fastest_in(stage: Stage, motion: Document, entry: Document) -> float:
    speeds, poses = _speeds(stage, motion, entry["frame"], 1)
    inside = (np.abs(_within(poses, entry)) < np.array(entry["size"]) / 2).all(axis=1)
    return float(speeds[inside].max(initial=0.0))


def _excess_zone(stage: Stage, motion: Document, entry: Document) -> float:
    return _fastest_in(stage, motion, entry) - entry["speed"]


def _constraint(name: str) -> Callable[[Document], str]:
    return lambda _: f"constraint 0: {name}"


def _bound(_: Stage, check: Any) -> float:
    return 20 * abs(check.bound)


def _one(_: Stage, __: Any) -> float:
    return 1.0


BOUNDS = {
    "keep_in": Bound(_draw_keep_in, _excess_in, _constraint("keep_in")),
    "keep_out": Bound(_draw_keep_out, _excess_out, _constraint("keep_out")),
    "position": Bound(_draw_band, _excess_in, _constraint("position")),
    "orientation": Bound(_draw_cone, _excess_cone, _constraint("orientation"), unit=_one),
    "distance_band": Bound(_draw_distance, _excess_distance, _constraint("distance_band")),
    "locked_joints": Bound(_draw_locked, _excess_locked, _constraint("locked_joints"), unit=_one),
    "joint_limits": Bound(_draw_tight, _excess_tight, _constraint("joint_limits"), unit=_one),
    "tool_limit": Bound(
        _draw_tool,
        _excess_tool,
        lambda entry: f"tool_{'speed' if 'speed' in entry else 'acceleration'} {entry['frame']}",
        share=1e-4,
        unit=_bound,
    ),
    "speed_zone": Bound(
        _draw_zone, _excess_zone, lambda _: "speed_zone zone", share=1e-4, unit=_bound
    ),
}
