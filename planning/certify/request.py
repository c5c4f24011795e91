"""CertifyRequest: a trajectory and everything it shall be held against."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.rounding import rounding
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.goals.linear_moves import LineSection
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.motion_limits import AccelerationBounds, SpeedZone, ToolLimit
from planning.domain.request.options import CertifyOptions
from planning.domain.robot.followers import Follower, together
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.payload import Payload
from planning.domain.value import Value
from planning.world.collision.margins import PairMargins

type Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, eq=False)
class CertifyRequest(Value):
    """What to prove.

    Attributes:
        group: What moves.
        trajectory: The motion.
        state: Where everything else is, full plant positions, shape (num_positions,).
        start: Where the motion shall begin, shape (nq,).
        goals: Configurations one of which it shall reach, shape (n, nq).
        limits: The limits that the group's own joints shall keep.
        margins: The distances to keep.
        jerk: Whether jerk is limited (and acceleration hence continuous).
        constraints: What else to keep; names and numbers in them are trusted.
        lines: Parts of the motion that shall follow straight lines.
        tool_limits: Limits of frames; names and numbers in them are trusted, as in the next two.
        speed_zones: Boxes in which frames are slower; what moves with the group counts where the
            `reference` puts it.
        acceleration_bounds: Lowest and highest accelerations of joints.
        options: What else to find out.
        origin: Where the motion began that this one goes on from, so that it need not begin at
            rest, shape (nq,); None if it begins by itself.
        effort: Whether joint torques and forces are limited.
        payload: What the group carries that the scene does not show.
        followers: Joints that follow those of the group, and the limits that they shall keep.
    """

    group: JointGroup
    trajectory: TimedTrajectory
    state: Float64[np.ndarray, " num_positions"]
    start: Float64[np.ndarray, " nq"]
    goals: Float64[np.ndarray, "n nq"]
    limits: JointLimits
    margins: PairMargins
    jerk: bool
    constraints: tuple[PathConstraint, ...] = ()
    lines: tuple[LineSection, ...] = ()
    tool_limits: tuple[ToolLimit, ...] = ()
    speed_zones: tuple[SpeedZone, ...] = ()
    acceleration_bounds: AccelerationBounds = field(default_factory=dict)
    options: CertifyOptions = field(default_factory=CertifyOptions)
    origin: Float64[np.ndarray, " nq"] | None = None
    effort: bool = False
    payload: Payload | None = None
    followers: tuple[Follower, ...] = ()

    @property
    def reference(self) -> Array:
        """The configuration that zones and constraints mean by the start, shape (nq,)."""
        return self.start if self.origin is None else self.origin

    @cached_property
    def shared_limits(self) -> JointLimits:
        """The limits within which the group and what follows it keep their own."""
        return together(self.limits, self.followers)

    @cached_property
    def leverage(self) -> Array:
        """By how much more than its own each rate may move something that follows, shape (nv,)."""
        factors = np.ones(self.group.num_velocities)
        for follower in self.followers:
            factors[follower.rate] = max(factors[follower.rate], abs(follower.multiplier))
        return factors

    @cached_property
    def rounding(self) -> tuple[Array, ...]:
        """Bounds on how far `forms` and values of the polynomials are off, each of shape (nv,)."""
        curve = self.trajectory
        return tuple(
            rounding(size, curve.coefficients, curve.widths, order)
            for order, size in enumerate(self.sizes)
        )

    @cached_property
    def sizes(self) -> tuple[Array, ...]:
        """The largest absolute values in `forms`, each of shape (nv,)."""
        return tuple(np.abs(form.reshape(len(form), -1)).max(axis=1) for form in self.forms)

    @cached_property
    def forms(self) -> tuple[Array, ...]:
        """The tangent and its derivatives, up to jerk if that is limited, in Bernstein form.

        Each has the shape (nv, n, k): of n pieces, with k the degree, at least 0, and one.
        """
        curve, count = self.trajectory, 4 if self.jerk else 3
        with np.errstate(over="ignore", invalid="ignore"):
            return bernstein.derivative_rows(curve.coefficients, curve.widths, count)
