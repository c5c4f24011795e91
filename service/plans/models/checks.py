"""Checks of a motion, and of its samples as receivers read them."""

from typing import Literal

from pydantic import Field

from service.api.arrays import FiniteOrNull
from service.api.document.known_values import CheckName, CheckUnit
from service.api.models import ResponseModel


class Check(ResponseModel):
    """One property that was checked on the whole interval."""

    name: CheckName = Field(
        description="Name of the check: position, velocity, acceleration, "
        "jerk, clearance, start, ..."
    )
    value: FiniteOrNull = Field(
        description="Worst value that was found, in `unit`; null for none. A check that "
        "failed may have worse values"
    )
    bound: FiniteOrNull = Field(
        description="Bound that it was held against, in `unit`; null for none"
    )
    unit: CheckUnit = Field(
        description="Unit of value, bound and resolution; `1` for peak over limit"
    )
    resolution: FiniteOrNull = Field(
        description="Bound on how far the true worst value may lie beyond `value`, in "
        "`unit`; null if there is none, for example where a search for it "
        "ended at once"
    )
    passed: bool = Field(description="Whether the property holds")
    where: str = Field(description="The joint or pair that is worst, or empty")
    time: float = Field(
        description="Time of the worst value [s]; not the first instant at which a check fails"
    )


class Interpolation(ResponseModel):
    """Verdict whether the samples, read in one way, keep what the motion was proven to keep."""

    kind: Literal["linear", "cubic", "quintic"] = Field(
        description="Interpolation between samples: straight lines (`linear`: positions "
        "alone), polynomials of degree 3 (`cubic`: positions and velocities) "
        "or of degree 5 (`quintic`: accelerations too)"
    )
    proven: bool = Field(
        description="Whether every check passed on the whole interval, those in "
        "`unchecked` excepted"
    )
    deviation: FiniteOrNull = Field(
        description="Largest distance of any coordinate from the exact motion [rad or m]; "
        "null if that is not known"
    )
    up_to_period: float | None = Field(
        description="Longest `sample_period` with which it is known to be proven [s]; the "
        "duration if any period is, null if none is known. For samples that "
        "are evenly apart, only their own period is considered"
    )
    failed: list[Check] = Field(description="Checks that did not pass")
    unchecked: list[CheckName] = Field(
        description="Checks of the certificate that straight lines are not held to: at every "
        "sample their velocity jumps"
    )
    reason: str = Field(description="Reason why it is not proven where no check says so, or empty")
