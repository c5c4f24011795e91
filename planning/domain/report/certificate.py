"""Certificate: proven properties of a trajectory, with bounds, resolution and worst cases."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry.body_pair import BodyPair
from planning.domain.geometry.unchecked_pair import UncheckedPair
from planning.domain.value import Value


@dataclass(frozen=True, eq=False)
class Check(Value):
    """Check of one property on the whole time interval.

    Attributes:
        name: position, velocity, acceleration, jerk, start, goal, continuity, clearance, or one of
            those that are made on request only.
        value: The worst value, in `unit`; a guaranteed bound where `resolution` is 0. Of a
            failed check it is the worst value met so far: there may be worse.
        bound: The permitted value, in `unit`.
        unit: Of value, bound and resolution; "1" for utilisation (peak over limit).
        resolution: Largest amount by which the true worst value may exceed `value`.
        passed: Whether the property holds.
        where: The joint, block or pair with the worst value, or "".
        time: Time of the worst value [s]; not the first instant at which a check fails.
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
    """Certificate of a timed trajectory, valid between its samples too.

    Not promised: anything about obstacles that are not in the scene, tracking error of the robot,
    or contact forces. Clearance is measured on Drake's geometry (a `Mesh` counts as its hull).

    Attributes:
        proven: Every check passed and clearance was bounded on the whole interval.
        min_clearance: If clearance is proven, a lower bound: no two checked bodies are ever nearer
            [m]. If it is not, there is no such bound and this is `observed_clearance`. Infinite if
            there is no pair to check.
        observed_clearance: Smallest signed distance at any measured instant [m]: an upper bound on
            the true smallest one, which lies between `min_clearance` and this.
        pair: The two bodies of `observed_clearance`, or ("", "").
        time: Time of `observed_clearance` [s].
        checks: All checks, passed or not.
        points: Their nearest points then, in world and in the order of `pair`: p_WA and p_WB [m];
            none without a pair. Of shapes that overlap they are the deepest.
        proven_until: All pairs are proven to keep their margins from the beginning until then [s]:
            the duration, if the check of clearance passed.
        first_unproven: The pair at which the proof stopped then, within a tenth of a millisecond,
            with its distance and nearest points; None if the proof is complete, or if the pair was
            not determined.
        unchecked: Pairs of bodies whose clearance is not checked, with reasons: the certificate
            says nothing about them.
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
        """Checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)

    @property
    def proven_clearance(self) -> float:
        """Proven lower bound of all distances [m]; minus infinity if there is none."""
        return self.min_clearance if self.proven else -np.inf
