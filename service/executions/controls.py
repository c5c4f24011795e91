"""Controls: what was asked of a running execution, in a file that its slot looks at.

A file works for every engine, survives the server, and is only ever replaced whole.
"""

import json
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Controls:
    """What a running execution should do.

    Attributes:
        is_paused: Whether it should rest.
        speed: How fast the trajectory should advance; 1 is real time.
    """

    is_paused: bool
    speed: float

    def write(self, path: Path) -> None:
        """Leave this where the execution looks for it."""
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_suffix(".new")
        told = {"is_paused": self.is_paused, "speed": self.speed}
        temporary.write_text(json.dumps(told), encoding="utf-8")
        temporary.replace(path)


def read_controls(path: Path, speed: float) -> Controls:
    """Return what was asked last, or to move at `speed` if nothing was."""
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return Controls(is_paused=False, speed=speed)
    return Controls(told["is_paused"], told["speed"])
