"""Certificate: what was proven of a trajectory, how finely it was looked at, and by how much."""

from dataclasses import dataclass

from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Check(Value):
    """One property that was checked on the whole interval.

    Attributes:
        name: position, velocity, acceleration, jerk, start, goal, continuity, clearance, or one of
            those that are only made if they are asked for.
        value: The worst value found, in `unit`; a guaranteed bound where `resolution` is 0.
        bound: What it was held against, in `unit`.
        unit: Of value, bound and resolution; "1" for utilisation (peak over limit).
        resolution: How far the true worst value may lie beyond `value`.
        passed: Whether the property holds.
        where: The joint, block or pair that is worst, or "".
        time: When it is worst [s].
    """

    name: str
    value: float
    bound: float
    unit: str
    resolution: float
    passed: bool
    where: str = ""
    time: float = 0.0


@dataclass(frozen=True, eq=False)
class Certificate(Value):
    """The verdict on a timed trajectory, between its samples too.

    Not promised: anything about obstacles that are not in the scene, tracking error of the robot,
    or forces; clearance is measured on Drake's geometry (a `Mesh` counts as its convex hull).

    Attributes:
        proven: Every check passed and clearance was bounded on the whole interval.
        min_clearance: Smallest signed distance found [m]; the true one is at most the clearance
            check's `resolution` below it. Infinite if there is no pair to look at.
        pair: The two bodies that come closest, or ("", "").
        time: When they do [s].
        checks: All checks, passed or not.
    """

    proven: bool
    min_clearance: float
    pair: tuple[str, str]
    time: float
    checks: tuple[Check, ...]

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)
