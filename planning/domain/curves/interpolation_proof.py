"""InterpolationProof: certificate of a sampled motion as a receiver interpolates it."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.report.certificate import Check
from planning.domain.value import Value

# Interpolations of the samples.
type Interpolation = Literal["linear", "cubic", "quintic", "cubic_spline"]


@dataclass(frozen=True, eq=False)
class InterpolationProof(Value):
    """Verdict on one interpolation of the samples.

    Attributes:
        kind: "linear" of positions alone, "cubic" of positions and velocities, or "quintic" of
            these and accelerations.
        proven: Whether it keeps all requirements of the motion, `unchecked` excepted, between
            samples too.
        deviation: Largest deviation of any coordinate from the motion itself [rad or m]; infinite
            where that is not known.
        up_to_period: Longest time between samples for which it is known to be proven [s]; None
            if none is known.
        failed: Checks that did not pass.
        unchecked: Requirements that are not checked, because straight lines have corners.
        reason: Why it is not proven, if no check failed; else "".
    """

    kind: Interpolation
    proven: bool
    deviation: float
    up_to_period: float | None
    failed: tuple[Check, ...] = ()
    unchecked: tuple[str, ...] = ()
    reason: str = ""
