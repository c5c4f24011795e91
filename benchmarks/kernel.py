"""Microseconds per configuration and per edge: the native kernel beside Drake's own checker.

A Panda among 10 to 10,000 boxes, cylinders and spheres that are scattered around it, and before the
bundled bookshelf. Both answer the same random configurations and edges in the same process and in
turns, Drake the first few of them only, as it takes the same time for each, and not among more
obstacles than it loads; the kernel's times include what it leaves to Drake. Motions of two UR5es,
far from each other and near, are proven beside each other by both as well; they are not times per
item but per proof.
"""

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import planning
from planning.certify.beside.beside_check import check_beside
from planning.certify.beside.beside_request import BesideRequest
from planning.kernel.native import kernel_name
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_oracle import KernelCollisionOracle
from planning.world.loading.load_world import MAX_OBJECTS_FOR_DRAKE

OBSTACLES = (10, 100, 1000, 10000)
BATCHES = (1, 16, 256, 4096)
ROUNDS = 5
# In one round: how often the kernel judges the same again, and how many items Drake judges at most.
KERNEL_REPEATS = 20
DRAKE_TAKES = 64
RESOLUTION = 0.05
_EDGE_LENGTH = 1.0
# Number of proofs of motions beside each other.
BESIDE = 10


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        scene: What surrounds the arm.
        what: Configurations in batches of so many, or edges.
        kernel_us: Median time per item with the kernel [us].
        drake_us: And with Drake alone [us]; None where there are too many obstacles for it.
        unsure: Share of configurations that were left to Drake.
        free: Share that is free.
    """

    scene: str
    what: str
    kernel_us: float
    drake_us: float | None
    unsure: float
    free: float

    @property
    def ratio(self) -> float | None:
        """How many times longer Drake takes."""
        return None if self.drake_us is None else self.drake_us / self.kernel_us


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--obstacles", type=int, nargs="+", default=OBSTACLES)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    rows = [*measured(options.obstacles, options.seed), *beside_rows(options.seed)]
    if options.json:
        print(json.dumps([asdict(row) | {"ratio": row.ratio} for row in rows]))
    else:
        Console().print(_table(rows))


def measured(obstacles: Sequence[int], seed: int, rounds: int = ROUNDS) -> Iterator[Row]:
    """Yield the rows of the bookshelf and of so many scattered obstacles each.

    Args:
        obstacles: Their numbers, one for each scene.
        seed: Of scenes, configurations and edges.
        rounds: How often both judges take turns; the first one warms up.
    """
    rng = np.random.default_rng(seed)
    shelf = planning.bundled_folder("scenes") / "panda_shelf.scene.yaml"
    yield from _scene_rows("bookshelf", planning.read_scene(shelf), rng, rounds)
    for count in obstacles:
        yield from _scene_rows(f"{count} obstacles", scattered(count, rng), rng, rounds)


def beside_rows(seed: int, rounds: int = ROUNDS) -> Iterator[Row]:
    """Yield the rows of motions of two arms that are proven beside each other, whatever the timing.

    Motions come from the seed, and the first ones that are proven are measured.
    """
    for name, apart in (("far", 3.0), ("near", 1.2)):
        rng = np.random.default_rng(seed)
        base = {"position": [apart, 0.0, 0.0]}
        robots = [{"name": "a", "model": "ur5e"}, {"name": "b", "model": "ur5e", "base": base}]
        world = planning.load_world(planning.parse_scene({"robots": robots, "margin": 0.02}))
        deadline = planning.Deadline.after(600.0, time.monotonic)
        with_drake = replace(world.drake, uses_kernel=False)
        requests: list[BesideRequest] = []
        while len(requests) < BESIDE:
            request = _beside_request(world, rng)
            if check_beside(world.drake, request, deadline).outcome == "PROVEN":
                requests.append(request)
        kernel_us, drake_us = _in_turns(
            partial(_prove_all, world.drake, requests, deadline),
            partial(_prove_all, with_drake, requests[:1], deadline),
            counts=(len(requests), 1),
            rounds=rounds,
        )
        yield Row(f"two arms, {name}", "2 s beside 2 s", kernel_us, drake_us, 0.0, 1.0)


def _beside_request(world: planning.World, rng: np.random.Generator) -> BesideRequest:
    first, second = world.group("a"), world.group("b")
    motions: list[planning.TimedTrajectory] = []
    for group in (first, second):
        q = world.positions(group) + rng.uniform(-0.7, 0.7, (4, group.num_positions))
        motions.append(planning.trajectory_through(group.joints, np.linspace(0.0, 2.0, 4), q))
    return BesideRequest((first, second), (motions[0], motions[1]), world.state, world.margins())


def _prove_all(model: DrakeModel, requests: Sequence[BesideRequest], deadline: Any) -> None:
    for request in requests:
        check_beside(model, request, deadline)


def scattered(count: int, rng: np.random.Generator) -> planning.Scene:
    """Return a Panda among obstacles 0.35 to 1.1 m from its base, smaller as they are more.

    Args:
        count: How many.
        rng: Decides where and what.
    """
    size = 0.25 / count ** (1 / 3)
    objects: list[dict[str, Any]] = []
    for i in range(count):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        a, b, c = size * rng.uniform(0.4, 1.0, 3)
        shapes = (
            {"box": [a, b, c]},
            {"cylinder": {"radius": a / 2, "length": b}},
            {"sphere": a / 2},
        )
        position = direction * rng.uniform(0.35, 1.1) + [0, 0, 0.4]
        pose = {"position": position.tolist(), "rpy": rng.uniform(-3, 3, 3).tolist()}
        objects.append({"name": f"thing_{i}", "shape": shapes[i % 3], "pose": pose})
    document = {
        "name": "scattered",
        "robots": [{"name": "panda", "model": "panda"}],
        "objects": objects,
    }
    return planning.parse_scene(document)


def _scene_rows(
    name: str, scene: planning.Scene, rng: np.random.Generator, rounds: int
) -> Iterator[Row]:
    has_drake = len(scene.objects) <= MAX_OBJECTS_FOR_DRAKE
    world = planning.load_world(scene, all_in_drake=has_drake)
    group = world.group("panda")
    limits, margins = world.limits(group), world.margins()
    kernel = world.collision_oracle(group, margins)
    drake = DrakeCollisionOracle(world.drake, group, world.state, margins) if has_drake else None
    qs = rng.uniform(limits.lower, limits.upper, (max(BATCHES), group.num_positions))
    free = kernel.are_free(qs)
    unsure = kernel.num_undecided / len(qs) if isinstance(kernel, KernelCollisionOracle) else 1.0
    for size in BATCHES:
        batch = qs[: max(size, 64)]
        kernel_us, drake_us = _in_turns(
            lambda batch=batch, size=size: _judge(kernel, batch, size),
            drake and (lambda batch=batch, size=size: _judge(drake, batch[:DRAKE_TAKES], size)),
            counts=(len(batch), min(len(batch), DRAKE_TAKES)),
            rounds=rounds,
        )
        yield Row(name, f"batches of {size}", kernel_us, drake_us, unsure, float(free.mean()))
    ends = rng.normal(size=(256, group.num_positions))
    ends *= _EDGE_LENGTH / np.linalg.norm(ends, axis=1)[:, None]
    starts = np.ascontiguousarray(qs[free][:256])
    ends = ends[: len(starts)]
    for claim, rows in _edges(kernel, starts, ends):
        some = rows[:DRAKE_TAKES]
        kernel_us, drake_us = _in_turns(
            lambda some=some: _judge_edges(kernel, starts[some], ends[some]),
            drake and (lambda some=some: _judge_edges(drake, starts[some], ends[some])),
            counts=(len(some), len(some)),
            rounds=rounds,
        )
        yield Row(name, f"{claim} edges of 1 rad", kernel_us, drake_us, unsure, float(free.mean()))


def _edges(kernel: Any, starts: Any, ends: Any) -> Iterator[tuple[str, Any]]:
    """Yield free edges and blocked ones, as rows."""
    free = kernel.are_motions_free(starts, ends, RESOLUTION)
    for claim, rows in (("free", np.flatnonzero(free)), ("blocked", np.flatnonzero(~free))):
        if len(rows):
            yield claim, rows


def _judge(oracle: Any, qs: Any, size: int) -> None:
    if size == 1:
        for q in qs:
            oracle.is_free(q)
        return
    for begin in range(0, len(qs), size):
        oracle.are_free(qs[begin : begin + size])


def _judge_edges(oracle: Any, starts: Any, ends: Any) -> None:
    for start, end in zip(starts, ends, strict=True):
        oracle.is_motion_free(start, end, RESOLUTION)


def _in_turns(
    kernel: Callable[[], None],
    drake: Callable[[], None] | None,
    *,
    counts: tuple[int, int],
    rounds: int,
) -> tuple[float, float | None]:
    """Return the median time per item of both [us]; each runs several times between the other."""
    times: tuple[list[float], list[float]] = ([], [])
    for round_ in range(rounds):
        for run, kept, repeat, count in zip(
            (kernel, drake), times, (KERNEL_REPEATS, 1), counts, strict=True
        ):
            began = time.perf_counter()
            if run is None:
                continue
            for _ in range(repeat):
                run()
            if round_:  # the first one warms up
                kept.append(1e6 * (time.perf_counter() - began) / (count * repeat))
    return statistics.median(times[0]), statistics.median(times[1]) if times[1] else None


def _table(rows: list[Row]) -> Table:
    table = Table(
        title=f"kernel ({kernel_name()}) and Drake, one core, medians of {ROUNDS - 1} rounds"
    )
    for column in ("scene", "what"):
        table.add_column(column)
    for column in ("kernel us", "Drake us", "ratio", "left to Drake", "free"):
        table.add_column(column, justify="right")
    for row in rows:
        table.add_row(
            row.scene,
            row.what,
            f"{row.kernel_us:.2f}",
            "-" if row.drake_us is None else f"{row.drake_us:.1f}",
            "-" if row.ratio is None else f"{row.ratio:.0f}",
            f"{100 * row.unsure:.2f} %",
            f"{100 * row.free:.0f} %",
        )
    return table


if __name__ == "__main__":
    main()
