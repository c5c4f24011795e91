"""Problems of the MotionBenchMaker data set, as files of JSON give them."""

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

# Third-party data: it lies beside the checkout, never in it.
BESIDE_THE_CHECKOUT = Path(__file__).resolve().parents[3] / "shared" / "mbm"
DATA_VARIABLE = "WAYPROOF_MBM"


class DataMissing(Exception):
    """A file that the benchmark reads is not there, or is not what it should be."""


@dataclass(frozen=True)
class Obstacle:
    """A primitive that does not move.

    Attributes:
        name: Unique in its problem.
        kind: "box", "cylinder" or "sphere".
        dims: Full sizes of a box; length and radius of a cylinder; radius of a sphere [m].
        position: p_WO [m].
        quaternion: R_WO as `[w, x, y, z]`.
    """

    name: str
    kind: str
    dims: tuple[float, ...]
    position: tuple[float, ...]
    quaternion: tuple[float, ...]


@dataclass(frozen=True)
class Problem:
    """Move an arm from a start to a goal among obstacles.

    Attributes:
        set: Name of the family of problems that it is from.
        index: Its number there.
        joints: Names, in the order of `start` and `goal`.
        start: Configuration [rad].
        goal: Configuration [rad].
        obstacles: What is in the way.
    """

    set: str
    index: int
    joints: tuple[str, ...]
    start: tuple[float, ...]
    goal: tuple[float, ...]
    obstacles: tuple[Obstacle, ...]

    @property
    def name(self) -> str:
        """Set and index, for people."""
        return f"{self.set} {self.index}"


def data_folder() -> Path:
    """Return the folder of the data: of the environment variable, else beside the checkout."""
    return Path(os.environ.get(DATA_VARIABLE) or BESIDE_THE_CHECKOUT)


def read_problems(file: Path, robot: str) -> list[Problem]:
    """Return a file's problems for a robot, in the order of the file.

    Raises:
        DataMissing: There is no such file, or it has no such problem.
    """
    if not file.is_file():
        message = (
            f"there are no problems at {file}: put the MotionBenchMaker problems there, or name "
            f"them with --problems FILE or the environment variable {DATA_VARIABLE} (a folder)"
        )
        raise DataMissing(message)
    documents: list[dict[str, Any]] = json.loads(file.read_text("utf-8"))
    problems = [_problem(entry) for entry in documents if entry.get("robot", robot) == robot]
    if not problems:
        message = f"{file} has no problem for the robot {robot!r}"
        raise DataMissing(message)
    return problems


def round_robin(problems: Iterable[Problem]) -> list[Problem]:
    """Return the first of every set, then the second of every set, and so on."""
    by_set: dict[str, list[Problem]] = {}
    for problem in problems:
        by_set.setdefault(problem.set, []).append(problem)
    rounds = chain.from_iterable(zip_longest(*by_set.values()))
    return [problem for problem in rounds if problem is not None]


def _problem(entry: dict[str, Any]) -> Problem:
    return Problem(
        set=entry["set"],
        index=entry["index"],
        joints=tuple(entry["joints"]),
        start=tuple(entry["start"]),
        goal=tuple(entry["goal"]),
        obstacles=tuple(
            Obstacle(
                thing["name"],
                thing["type"],
                tuple(thing["dims"]),
                tuple(thing["pos"]),
                tuple(thing["quat"]),
            )
            for thing in entry["objects"]
        ),
    )
