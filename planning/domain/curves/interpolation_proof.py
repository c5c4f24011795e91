"""InterpolationProof: whether samples of a motion are proven, read as a receiver may read them."""

from dataclasses import dataclass
from typing import Literal

from planning.domain.report.certificate import Check
from planning.domain.value import Value

# What samples may be taken for.
type Interpolation = Literal["linear", "cubic", "quintic", "cubic_spline"]


@dataclass(frozen=True, eq=False)
class InterpolationProof(Value):
    """The verdict on what a receiver makes of samples.

    Attributes:
        kind: "linear" of positions alone, "cubic" of positions and velocities, or "quintic" of
            these and accelerations.
        proven: It keeps all that the motion was asked to keep, `unchecked` excepted, between
            samples too.
        deviation: How far any coordinate is from the motion itself at most [rad or m]; infinite
            where that is not known.
        up_to_period: The longest time between samples with which it is known to be proven [s]; None
            if none is known.
        failed: The checks that did not pass.
        unchecked: What it is not held to, because straight lines have corners.
        reason: Why it is not proven where no check says so, or "".
    """

    kind: Interpolation
    proven: bool
    deviation: float
    up_to_period: float | None
    failed: tuple[Check, ...] = ()
    unchecked: tuple[str, ...] = ()
    reason: str = ""
