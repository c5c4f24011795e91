"""PathMotion: where a setpoint is on its path, how fast, and how that changes within limits."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointLimits
from planning.domain.value import Value
from planning.execute.barrier import Barrier
from planning.execute.time_scaling import choose_path_acceleration, path_acceleration_bounds

# Path velocities that differ by less are equal: rounding must not keep a robot from resting.
_PATH_VELOCITY_TOLERANCE = 1e-12


class PathLimits(NamedTuple):
    """Limits on the motion along a path.

    Attributes:
        joints: Joint limits; the acceleration limits hold while the path velocity changes.
        path_acceleration: Largest magnitude of the path acceleration [1/s].
        ahead: What it does not pass forwards, if anything.
        behind: What it does not pass backwards, on the reversed trajectory, if anything.
    """

    joints: JointLimits
    path_acceleration: float
    ahead: Barrier | None = None
    behind: Barrier | None = None


@dataclass(frozen=True, eq=False)
class PathMotion(Value):
    """State of a point s that moves along a trajectory q(s), forwards or backwards.

    Attributes:
        time: s, the time along the trajectory [s].
        velocity: s', the seconds of trajectory per second of the driver's clock, in [-1, 1].
        acceleration: s'', its derivative until the next step [1/s].
    """

    time: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0

    def accelerated(
        self, trajectory: TimedTrajectory, limits: PathLimits, target: float, period: float
    ) -> "PathMotion":
        """Return the same place and velocity with the s'' of the next period [s].

        It brings s' as near to `target` as the limits allow. Where s' changes its sign it comes to
        0 first, at the end of a period: from there any s'' is safe that is safe at 0.
        """
        goal = target if self.velocity * target >= 0 else 0.0
        most = limits.path_acceleration
        change = float(np.clip(goal - self.velocity, -most * period, most * period))
        end = float(np.clip(self.time + self.velocity * period, 0.0, trajectory.duration))
        # The limits must hold at the end of the period too, at the least and the largest velocity.
        times = np.array([self.time, end, end])
        velocities = self.velocity + np.array([0.0, 0.0, change])
        lower, upper = path_acceleration_bounds(trajectory, limits.joints, times, velocities)
        bounds = max(lower, -most), min(upper, most)
        chosen = choose_path_acceleration(bounds, self.velocity, goal, period)
        lower, upper = min(bounds[0], 0.0), max(bounds[1], 0.0)
        if limits.ahead is not None:
            place = self.time, self.velocity
            chosen = limits.ahead.limited(place, (lower, upper), chosen, period)
        if limits.behind is not None:
            place = trajectory.duration - self.time, -self.velocity
            chosen = -limits.behind.limited(place, (-upper, -lower), -chosen, period)
        return replace(self, acceleration=chosen)

    def moved(self, duration: float, target: float, period: float) -> "PathMotion":
        """Return the motion after a period [s] of its acceleration; it rests at both ends."""
        velocity = self.velocity + self.acceleration * period
        if abs(velocity) < _PATH_VELOCITY_TOLERANCE:
            velocity = 0.0
        elif abs(velocity - target) < _PATH_VELOCITY_TOLERANCE:
            velocity = target
        time = self.time + 0.5 * (self.velocity + velocity) * period
        if time >= duration and velocity >= 0:
            return replace(self, time=duration, velocity=0.0)
        if time <= 0 and velocity <= 0:
            return replace(self, time=0.0, velocity=0.0)
        return replace(self, time=float(np.clip(time, 0.0, duration)), velocity=velocity)

    def rates(self, trajectory: TimedTrajectory) -> tuple[Array, Array]:
        """Return v = q' s' and vdot = q'' s'^2 + q' s'', shapes (nv,)."""
        times = np.array([self.time])
        velocity = trajectory.velocities(times)[0]
        curvature = trajectory.accelerations(times)[0]
        vdot = curvature * self.velocity**2 + velocity * self.acceleration
        return velocity * self.velocity, vdot
