"""CertifyRequest: a trajectory and all limits, margins and constraints to prove for it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals import bernstein
from planning.certify.intervals.rounding import rounding_bounds
from planning.certify.joints.joint_bounds import JointBounds
from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.goals.linear_moves import LineSection
from planning.domain.request.constraint import PathConstraint
from planning.domain.request.drake_term import DrakeTerm
from planning.domain.request.motion_limits import AccelerationBounds, SpeedZone, ToolLimit
from planning.domain.request.options import CertifyOptions
from planning.domain.robot.followers import Follower, combine_limits
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.payload import Payload
from planning.domain.value import Value
from planning.world.collision.margins import PairMargins


@dataclass(frozen=True, eq=False)
class CertifyRequest(Value):
    """A trajectory and the properties to prove for it.

    Attributes:
        group: The joint group that moves.
        trajectory: The motion.
        state: Full plant positions, for all joints outside of the group, shape (num_positions,).
        start: Required first configuration, shape (nq,).
        goals: Goal configurations, one of which the motion must reach, shape (n, nq).
        limits: Limits of the group's own joints.
        margins: Required distances between bodies.
        jerk: Whether jerk is limited (and acceleration hence continuous).
        constraints: Path constraints; names and numbers in them are trusted.
        lines: Sections of the motion on which a tool must follow a straight line.
        tool_limits: Speed and acceleration limits of frames; names and numbers in them are trusted,
            as in the next two.
        speed_zones: Boxes with a lower speed limit for a frame; boxes on moving bodies are placed
            by the `reference` configuration.
        acceleration_bounds: Lowest and highest accelerations of joints.
        options: Additional findings to compute.
        origin: First configuration of the running motion that this one continues, so that it need
            not begin at rest, shape (nq,); None if it begins at rest.
        effort: Whether joint torques and forces are limited.
        payload: Load carried by the group that is not part of the scene.
        followers: Mimic joints that follow those of the group, and their limits.
        terms: Constraints in Drake's language, which are evaluated at their own instants.
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
    terms: tuple[DrakeTerm, ...] = ()

    @property
    def reference(self) -> Array:
        """The reference configuration of zones and constraints (their "start"), shape (nq,)."""
        return self.start if self.origin is None else self.origin

    @cached_property
    def limits_with_followers(self) -> JointLimits:
        """The limits of the group, tightened so that its follower joints keep theirs."""
        return combine_limits(self.limits, self.followers)

    @cached_property
    def follower_ratios(self) -> Array:
        """Largest ratio of a follower's rate to each coordinate's rate, at least 1, shape (nv,)."""
        factors = np.ones(self.group.num_velocities)
        for follower in self.followers:
            factors[follower.velocity_index] = max(
                factors[follower.velocity_index], abs(follower.multiplier)
            )
        return factors

    @cached_property
    def joint_bounds(self) -> JointBounds | None:
        """Bounds on the joints by the kernel; None where numpy computes them.

        Only once the numbers of the trajectory are known to be well-formed.
        """
        if self.followers:
            return None
        rates = ("velocity", "acceleration", "jerk") if self.jerk else ("velocity", "acceleration")
        return JointBounds.of(self.trajectory, self.group, self.limits, rates)

    @cached_property
    def rounding_errors(self) -> tuple[Array, ...]:
        """Bounds on rounding errors of `bernstein_forms` and of polynomials, each shape (nv,)."""
        curve = self.trajectory
        return tuple(
            rounding_bounds(size, curve.coefficients, curve.widths, order)
            for order, size in enumerate(self.max_magnitudes)
        )

    @cached_property
    def max_magnitudes(self) -> tuple[Array, ...]:
        """The largest absolute values in `bernstein_forms`, each of shape (nv,)."""
        if self.joint_bounds is not None:
            return tuple(self.joint_bounds.magnitudes)
        return tuple(
            np.abs(form.reshape(len(form), -1)).max(axis=1) for form in self.bernstein_forms
        )

    @cached_property
    def bernstein_forms(self) -> tuple[Array, ...]:
        """The tangent and its derivatives, up to jerk if that is limited, in Bernstein form.

        Each has the shape (nv, n, k): of n pieces, with k the degree, at least 0, and one.
        """
        if self.joint_bounds is not None:
            return self.joint_bounds.forms
        curve, count = self.trajectory, 4 if self.jerk else 3
        with np.errstate(over="ignore", invalid="ignore"):
            return bernstein.derivative_rows(curve.coefficients, curve.widths, count)
