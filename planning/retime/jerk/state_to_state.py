"""State-to-state motions by ruckig: time-optimal transitions, or stops, under jerk limits.

Berscheid and Kroeger, "Jerk-limited real-time trajectory generation with arbitrary target states",
RSS 2021. Each joint has phases of constant jerk; where a phase of any joint begins, all of them
begin a new piece of degree 3.
"""

from types import MappingProxyType
from typing import Any

import numpy as np
import ruckig

from planning.domain.arrays import Array
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.motion_state import MotionState
from planning.domain.request.motion_limits import AccelerationBounds
from planning.domain.robot.joints import Joint, JointLimits, JointType
from planning.errors import RetimingFailed

# Cycle time [s], required by ruckig's constructor and used only in its online mode.
_CYCLE_TIME = 0.01
# Factor on the limits for a state that lies on them; the certifier's tolerance is five times as
# large.
_LIMIT_FACTOR = 1 + 2e-7
# Shortest phase [s]; shorter ones are left out.
_MIN_PHASE = 1e-9
_SCALAR_JOINT_TYPES = {JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC}


def to_rest(
    joints: tuple[Joint, ...],
    limits: JointLimits,
    state: MotionState,
    bounds: AccelerationBounds = MappingProxyType({}),
) -> TimedTrajectory:
    """Return the fastest stop: every joint brakes independently, wherever it comes to rest.

    Raises:
        RetimingFailed: A joint is planar or floating, or ruckig finds no profile.
    """
    ruckig_input = _ruckig_input(joints, limits, state, bounds)
    ruckig_input.control_interface = ruckig.ControlInterface.Velocity
    ruckig_input.synchronization = ruckig.Synchronization.No
    ruckig_input.target_velocity = ruckig_input.target_acceleration = [0.0] * len(joints)
    return _solve(joints, ruckig_input)


def to_state(
    joints: tuple[Joint, ...],
    limits: JointLimits,
    state: MotionState,
    target: MotionState,
    bounds: AccelerationBounds = MappingProxyType({}),
) -> TimedTrajectory:
    """Return the fastest motion to a target state, moving or at rest; all joints arrive together.

    Raises:
        RetimingFailed: A joint is planar or floating, or ruckig finds no profile.
    """
    ruckig_input = _ruckig_input(joints, limits, state, bounds)
    ruckig_input.target_position = target.q.tolist()
    ruckig_input.target_velocity = target.v.tolist()
    ruckig_input.target_acceleration = target.vdot.tolist()
    return _solve(joints, ruckig_input)


def _ruckig_input(
    joints: tuple[Joint, ...], limits: JointLimits, state: MotionState, bounds: AccelerationBounds
) -> Any:
    unsupported = [joint.name for joint in joints if joint.type not in _SCALAR_JOINT_TYPES]
    if unsupported:
        message = f"planar and floating joints have no state-to-state motions: {unsupported}"
        raise RetimingFailed(message, {"method": "ruckig", "joints": unsupported})
    ruckig_input = ruckig.InputParameter(len(joints))
    ruckig_input.current_position = state.q.tolist()
    ruckig_input.current_velocity = state.v.tolist()
    ruckig_input.current_acceleration = state.vdot.tolist()
    signed_bounds = [bounds.get(joint.name, (-np.inf, np.inf)) for joint in joints]
    lowest = np.maximum([low for low, _ in signed_bounds], -limits.acceleration)
    highest = np.minimum([high for _, high in signed_bounds], limits.acceleration)
    ruckig_input.min_acceleration = (lowest * _LIMIT_FACTOR).tolist()
    ruckig_input.max_velocity, ruckig_input.max_acceleration, ruckig_input.max_jerk = (
        (bound * _LIMIT_FACTOR).tolist() for bound in (limits.velocity, highest, limits.jerk)
    )
    return ruckig_input


def _solve(joints: tuple[Joint, ...], ruckig_input: Any) -> TimedTrajectory:
    solution = ruckig.Trajectory(len(joints))
    try:
        code = int(ruckig.Ruckig(len(joints), _CYCLE_TIME).calculate(ruckig_input, solution))
        reason = f"code {code}"
    except ruckig.RuckigError as fault:
        code, reason = -1, str(fault).strip().splitlines()[0]
    except ValueError:  # ruckig's ErrorTrajectoryDuration, which its Python enumeration lacks
        code, reason = -101, "it would take longer than ruckig computes"
    if code < 0:
        message = f"ruckig found no motion between the states: {reason}"
        raise RetimingFailed(message, {"method": "ruckig", "result": reason})
    breaks = _breaks(solution, float(solution.duration))
    states = np.array([solution.at_time(float(t)) for t in breaks])
    q, v, vdot = states[:-1, 0], states[:-1, 1], states[:-1, 2]
    # Jerk is constant on a piece.
    jerk = (states[1:, 2] - vdot) / np.diff(breaks)[:, None]
    coefficients = np.stack([np.zeros_like(q), v, vdot / 2, jerk / 6], axis=1)
    return TimedTrajectory(joints, breaks, q, coefficients)


def _breaks(solution: Any, duration: float) -> Array:
    """Return the instants at which a phase of any joint begins, and both ends [s]."""
    instants = [0.0, duration]
    for profile in solution.profiles[0]:
        phases = [*profile.brake.t, *profile.t]
        instants += np.cumsum(phases).tolist()
    inside = np.unique([t for t in instants if _MIN_PHASE < t < duration - _MIN_PHASE])
    breaks = [0.0]
    for t in inside:
        if t - breaks[-1] > _MIN_PHASE:
            breaks.append(float(t))
    return np.array([*breaks, max(duration, breaks[-1] + _MIN_PHASE)])
