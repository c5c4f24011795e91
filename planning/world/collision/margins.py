"""PairMargins: the distance that is demanded of two bodies."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Int

from planning.domain.value import Value

# A margin that any two bodies keep, wherever they are [m].
_GONE = -1e3


@dataclass(frozen=True, eq=False)
class PairMargins(Value):
    """The scene's margin with its exceptions.

    The bodies of one robot owe each other no margin, only that they do not touch: neighbouring
    links are often nearer than any useful margin, whatever the configuration. What a robot holds
    counts as a body of it.

    Attributes:
        default: Distance between bodies of different robots and objects [m].
        by_pair: Exceptions, keyed by the two full names in sorted order.
        owners: The robot that holds an object, by the object's name.
    """

    default: float
    by_pair: dict[tuple[str, str], float] = field(default_factory=dict)
    owners: Mapping[str, str] = field(default_factory=dict)

    def of(self, body_a: str, body_b: str) -> float:
        """Return the margin of two bodies by their full names [m]."""
        low, high = sorted((body_a, body_b))
        exception = self.by_pair.get((low, high))
        if exception is not None:
            return exception
        return 0.0 if self.are_of_one_robot(body_a, body_b) else self.default

    def without(self, body: str, others: Iterable[str]) -> "PairMargins":
        """Return margins under which a body is not there: it may be in any of the others."""
        gone = {(min(body, other), max(body, other)): _GONE for other in others if other != body}
        return replace(self, by_pair={**self.by_pair, **gone})

    def are_of_one_robot(self, body_a: str, body_b: str) -> bool:
        """Return whether two bodies are parts of one robot, or held by it."""
        robot_a, robot_b = self._robot(body_a), self._robot(body_b)
        return robot_a is not None and robot_a == robot_b

    def robots_of(self, bodies: Sequence[str]) -> Int[np.ndarray, " n"]:
        """Return a number for the robot of each body, by full names; -1 for that of none."""
        numbers: dict[str, int] = {}
        robots = [self._robot(body) for body in bodies]
        return np.array(
            [-1 if robot is None else numbers.setdefault(robot, len(numbers)) for robot in robots],
            dtype=np.intp,
        )

    def _robot(self, body: str) -> str | None:
        robot, has_robot, _ = body.partition("::")
        return robot if has_robot else self.owners.get(body)

    @property
    def largest(self) -> float:
        """The largest margin of any pair [m]."""
        return max([self.default, *self.by_pair.values()])
