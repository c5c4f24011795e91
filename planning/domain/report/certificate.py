"""Certificate: what was proven of a trajectory, how finely it was looked at, and by how much."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Check(Value):
    """One property that was checked on the whole interval.

    Attributes:
        name: position, velocity, acceleration, jerk, start, goal, continuity, clearance, or one of
            those that are only made if they are asked for.
        value: The worst value found, in `unit`; a guaranteed bound where `resolution` is 0. Of a
            check that failed it is the worst that was seen until then: there may be worse.
        bound: What it was held against, in `unit`.
        unit: Of value, bound and resolution; "1" for utilisation (peak over limit).
        resolution: How far the true worst value may lie beyond `value`.
        passed: Whether the property holds.
        where: The joint, block or pair that is worst, or "".
        time: When that is [s]; not the first instant at which a check fails.
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
    or contact forces. Clearance is measured on Drake's geometry (a `Mesh` counts as its hull).

    Attributes:
        proven: Every check passed and clearance was bounded on the whole interval.
        min_clearance: If clearance is proven, a lower bound: no two bodies that are looked at are
            ever nearer [m]. If it is not, there is no such bound and this is `observed_clearance`.
            Infinite if there is no pair to look at.
        observed_clearance: Smallest signed distance at any instant that was measured [m]: an upper
            bound on the true smallest one, which lies between `min_clearance` and this.
        pair: The two bodies of `observed_clearance`, or ("", "").
        time: When it was observed [s].
        checks: All checks, passed or not.
        points: Their nearest points then, in world and in the order of `pair`: p_WA and p_WB [m];
            none without a pair. Of shapes that overlap they are the deepest.
        proven_until: All pairs are proven to keep their margins from the beginning until then [s]:
            the duration, if the check of clearance passed.
        first_unproven: The pair that stopped the proof there, within a tenth of a millisecond, with
            its distance and nearest points; None if nothing did, or if it was not looked for.
        unchecked: Pairs of bodies whose clearance is not looked at, and why: nothing is said of
            them.
    """

    proven: bool
    min_clearance: float
    observed_clearance: float
    pair: tuple[str, str]
    time: float
    checks: tuple[Check, ...]
    points: Float64[np.ndarray, "k 3"] = field(default_factory=lambda: np.zeros((0, 3)))
    proven_until: float = 0.0
    first_unproven: BodyPair | None = None
    unchecked: tuple[UncheckedPair, ...] = ()

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def proven_clearance(self) -> float:
        """What no distance is below along the motion [m]; minus infinity if it is not proven."""
        return self.min_clearance if self.proven else -np.inf
