"""switch_motion(): an execution goes on along another motion, which its robot is on already."""

from dataclasses import replace

import numpy as np

from planning.domain.curves.curve import TimedTrajectory
from planning.errors import ProblemInvalid
from planning.execute.execution import Execution

# Largest distance of setpoints, and of their velocities, before and after [rad or m, per s].
_TOLERANCE = 1e-6


def switch_motion(execution: Execution, trajectory: TimedTrajectory, place: float) -> Execution:
    """Return an execution that goes on along another motion, without a jump.

    Barriers are left behind with the motion that they were on.

    Args:
        execution: That goes on.
        trajectory: The other motion; it rests at its end.
        place: Where on it the robot is, time along the trajectory [s].

    Raises:
        ProblemInvalid: The motion is not where the robot should be now, or not as quick there; or
            it is of other joints.
    """
    if trajectory.joints != execution.trajectory.joints:
        message = "trajectory: it is of other joints than the motion that is carried out"
        raise ProblemInvalid(message, {"field": "trajectory"})
    motion = replace(execution.motion, time=place)
    distance = _largest(
        trajectory.manifold.minus(trajectory.positions(np.array([place]))[0], execution.desired)
    )
    v_before, _ = execution.motion.rates(execution.trajectory)
    v_after, _ = motion.rates(trajectory)
    jump = _largest(v_after - v_before)
    if not 0 <= place <= trajectory.duration or max(distance, jump) > _TOLERANCE:
        message = (
            f"trajectory: at {place:g} s it is {distance:.3g} rad or m from where the robot should "
            f"be, and its velocity differs by {jump:.3g} rad/s or m/s"
        )
        raise ProblemInvalid(message, {"field": "trajectory", "distance": distance, "jump": jump})
    switched = replace(execution, trajectory=trajectory, motion=motion, at_rest_since=None)
    return switched.between(None, None)


def _largest(differences: np.ndarray) -> float:
    return float(np.max(np.abs(differences), initial=0.0))
