"""PairMargins: the distance that is demanded of two bodies."""

from dataclasses import dataclass, field

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class PairMargins(Value):
    """The scene's margin with its exceptions.

    The bodies of one robot owe each other no margin, only that they do not touch: neighbouring
    links are often nearer than any useful margin, whatever the configuration.

    Attributes:
        default: Distance between bodies of different robots and objects [m].
        by_pair: Exceptions, keyed by the two full names in sorted order.
    """

    default: float
    by_pair: dict[tuple[str, str], float] = field(default_factory=dict)

    def of(self, body_a: str, body_b: str) -> float:
        """Return the margin of two bodies by their full names [m]."""
        low, high = sorted((body_a, body_b))
        exception = self.by_pair.get((low, high))
        if exception is not None:
            return exception
        robot_a, has_robot_a, _ = body_a.partition("::")
        robot_b, has_robot_b, _ = body_b.partition("::")
        return 0.0 if has_robot_a and has_robot_b and robot_a == robot_b else self.default

    @property
    def largest(self) -> float:
        """The largest margin of any pair [m]."""
        return max([self.default, *self.by_pair.values()])
