"""PairMargins: collision margin of every pair of bodies [m], the scene's with its exceptions."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Int

from planning.domain.value import Value

# Margin that any two bodies keep at any configuration: an overlap of up to a kilometre [m].
_IGNORED_MARGIN = -1e3


@dataclass(frozen=True, eq=False)
class PairMargins(Value):
    """Collision margins by pair of bodies.

    The bodies of one robot have no margin, they only must not touch: neighbouring links are often
    nearer than any useful margin, at every configuration. An attached object counts as a body of
    its robot.

    Attributes:
        default: Distance between bodies of different robots and objects [m].
        by_pair: Exceptions, keyed by the two full names in sorted order.
        owners: The robot of each attached object, by the object's name.
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

    def ignoring(self, body: str, others: Iterable[str]) -> "PairMargins":
        """Return margins under which a body is ignored: it may overlap any of the others."""
        ignored = {
            (min(body, other), max(body, other)): _IGNORED_MARGIN
            for other in others
            if other != body
        }
        return replace(self, by_pair={**self.by_pair, **ignored})

    def are_of_one_robot(self, body_a: str, body_b: str) -> bool:
        """Return whether two bodies are parts of one robot, or attached to it."""
        robot_a, robot_b = self._robot(body_a), self._robot(body_b)
        return robot_a is not None and robot_a == robot_b

    def robots_of(self, bodies: Sequence[str]) -> Int[np.ndarray, " n"]:
        """Return the index of each body's robot, by full names; -1 for bodies of no robot."""
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
