"""Seconds until a scene answers, by its size: `make bench-loading`, or `benchmarks/loading.py -h`.

Boxes stand about a UR5e; one of them is moved, and the scene is asked again. Times are those of
this process alone, so that a busy machine tells no other ones; memory is the most that it had. Each
scene has a process of its own.
"""

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import planning

BOXES = (10, 100, 1_000, 10_000)
ROBOTS, FRAMES = 64, 10_000
COLUMNS = ("read", "loaded", "first check", "one moved", "next check", "MB")


def boxes(count: int, seed: int = 0) -> dict[str, Any]:
    """Return a scene of an arm among `count` boxes, none of them where it stands."""
    places = np.random.default_rng(seed).uniform(-3.0, 3.0, (count, 3))
    places[np.linalg.norm(places[:, :2], axis=1) < 1.2, 0] += 3.0
    return {
        "name": "boxes",
        "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
        "objects": [
            {
                "name": f"box_{i}",
                "shape": {"box": [0.05, 0.05, 0.05]},
                "pose": {"position": place, "rpy": [0.0, 0.0, 0.1 * (i % 60)]},
            }
            for i, place in enumerate(places.tolist())
        ],
    }


def robots(count: int) -> dict[str, Any]:
    """Return a scene of `count` arms, eight in a row, out of each other's reach, and one box."""
    arms = [
        {
            "name": f"arm_{i}" if i else "arm",
            "model": "ur5e",
            "base": {"position": [2.5 * (i % 8), 2.5 * (i // 8), 0.0]},
            "positions": "home",
        }
        for i in range(count)
    ]
    return {**boxes(1), "name": "robots", "robots": arms}


def frames(count: int) -> dict[str, Any]:
    """Return a scene of a chain of `count` frames on the arm's tool, and one box."""
    chain = [
        {
            "name": f"frame_{i}",
            "parent": f"frame_{i - 1}" if i else "arm::tool0",
            "pose": {"position": [1e-4, 0.0, 0.0]},
        }
        for i in range(count)
    ]
    return {**boxes(1), "name": "frames", "frames": chain}


KINDS: dict[str, Callable[[int], dict[str, Any]]] = {
    "boxes": boxes,
    "robots": robots,
    "frames": frames,
}


def measured(document: dict[str, Any], clock: Callable[[], float]) -> dict[str, float]:
    """Return the seconds that each step took, and the most memory of this process [MB]."""
    times = [clock()]
    scene = planning.parse_scene(document)
    times.append(clock())
    world = planning.load_world(scene)
    times.append(clock())
    group = world.groups[0]
    q = world.positions(group)[None]
    planning.check_configurations(world, group.name, q)
    times.append(clock())
    pose = planning.Pose.from_parts((0.6, 0.2, 0.9))
    edited = planning.edit_scene(world.scene, [planning.MoveObject("box_0", pose)])
    world = planning.load_world(edited, previous=world)
    times.append(clock())
    planning.check_configurations(world, group.name, q)
    times.append(clock())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return dict(zip(COLUMNS, [*np.diff(times).tolist(), memory], strict=True))


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--boxes", type=int, nargs="*", default=BOXES)
    parser.add_argument("--robots", type=int, nargs="*", default=(ROBOTS,))
    parser.add_argument("--frames", type=int, nargs="*", default=(FRAMES,))
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one", nargs=2, metavar=("KIND", "COUNT"), help="in this process")
    options = parser.parse_args(arguments)
    if options.one:
        kind, count = options.one
        # The first scene of a process imports half of what there is.
        measured(boxes(1), time.process_time)
        print(json.dumps(measured(KINDS[kind](int(count)), time.process_time)))
        return
    sizes = [(kind, count) for kind in KINDS for count in getattr(options, kind)]
    rows = {f"{count:,} {kind}": _in_a_process(kind, count) for kind, count in sizes}
    if options.json:
        print(json.dumps(rows))
    else:
        Console().print(_table(rows))


def _in_a_process(kind: str, count: int) -> dict[str, float]:
    command = [sys.executable, __file__, "--one", kind, str(count)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(told)


def _table(rows: dict[str, dict[str, float]]) -> Table:
    table = Table("scene", *COLUMNS, title="seconds of this process, and megabytes")
    for name, row in rows.items():
        table.add_row(name, *(f"{row[c]:.0f}" if c == "MB" else f"{row[c]:.3f}" for c in COLUMNS))
    return table


if __name__ == "__main__":
    main()
