"""Checks of a motion, and of its samples as receivers read them."""

from typing import Literal

from pydantic import Field

from service.api.arrays import FiniteOrNull
from service.api.models import ResponseModel


class Check(ResponseModel):
    """One property that was checked on the whole interval."""

    name: str = Field(description="position, velocity, acceleration, jerk, clearance, start, ...")
    value: FiniteOrNull = Field(
        description="The worst value found, in `unit`; of a check that failed the worst seen until "
        "then, there may be worse; null for none"
    )
    bound: FiniteOrNull = Field(description="What it was held against, in `unit`; null for none")
    unit: str = Field(description="Unit of value, bound and resolution; `1` for peak over limit")
    resolution: FiniteOrNull = Field(
        description="How far the true worst value may lie beyond `value`; null if it is not "
        "bounded, as where a search for it ended at once"
    )
    passed: bool = Field(description="Whether the property holds")
    where: str = Field(description="The joint or pair that is worst, or empty")
    time: float = Field(
        description="When that is [s]; not the first instant at which a check fails"
    )


class Interpolation(ResponseModel):
    """Whether the samples keep what the motion was proven to keep, read in one way."""

    kind: Literal["linear", "cubic", "quintic"] = Field(
        description="Between samples a receiver goes straight (`linear`: positions alone), by the "
        "polynomial of degree 3 (`cubic`: positions and velocities) or of degree 5 (`quintic`: "
        "accelerations too)"
    )
    proven: bool = Field(
        description="Every check passed on the whole interval, those in `unchecked` excepted"
    )
    deviation: FiniteOrNull = Field(
        description="How far any coordinate is from the exact motion at most [rad or m]; null if "
        "that is not known"
    )
    up_to_period: float | None = Field(
        description="The longest `sample_period` with which it is known to be proven [s], the "
        "duration if that is however long; of samples that are evenly apart only that of theirs; "
        "null if none is known"
    )
    failed: list[Check] = Field(description="The checks that did not pass")
    unchecked: list[str] = Field(
        description="Checks of the certificate that straight lines are not held to: at every "
        "sample their velocity jumps"
    )
    reason: str = Field(description="Why it is not proven where no check says so, or empty")
