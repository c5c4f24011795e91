"""How long scenes of many boxes take: posted, and one box moved until the next check."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.service_load.host import ARM, Host, timed
from benchmarks.service_load.measure import Measure

_CHECK = {"group": "arm", "configurations": [[0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]]}


def boxes(host: Host, sizes: Sequence[int], limit: float) -> Iterator[Measure]:
    """Post a scene of each number of boxes, move one box in it, and yield how long both take."""
    for size in sizes:
        loaded = Measure(f"{size:,} boxes: posted", limit=limit)
        moved = Measure(f"{size:,} boxes: one moved, and the next check", limit=limit)
        host.need()
        scene = timed(loaded, host, lambda size=size: host.post("/v1/scenes", scene_of(size)))
        if scene is None:
            moved.faults.append("it was not posted")
        else:
            timed(moved, host, lambda scene=scene: _move_one(host, scene["id"]))
        yield from (loaded, moved)


def scene_of(size: int) -> dict[str, Any]:
    """Return a UR5e beside a cube of small boxes that do not touch each other."""
    side = math.ceil(size ** (1 / 3))
    objects = [
        {
            "name": f"box_{i}",
            "shape": {"box": [0.04, 0.04, 0.04]},
            "pose": {"position": [1.2 + 0.1 * (i % side), *_rest(i, side)]},
            "movable": True,
        }
        for i in range(size)
    ]
    return {**ARM, "name": f"boxes_{size}", "objects": objects}


def _rest(i: int, side: int) -> tuple[float, float]:
    return 0.1 * (i // side % side), 0.1 * (i // side**2)


def _move_one(host: Host, scene: str) -> None:
    pose = {"position": [1.2, -0.2, 0.0]}
    edit = {"operations": [{"op": "move", "object": "box_0", "pose": pose}]}
    answer = host.http.patch(f"/v1/scenes/{scene}", json=edit)
    answer.raise_for_status()
    host.post(f"/v1/scenes/{scene}/check", _CHECK)
