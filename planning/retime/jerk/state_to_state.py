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
_CYCLE = 0.01
# Factor on the limits for a state that lies on them; the certifier's tolerance is five times as
# large.
_ROOM = 1 + 2e-7
# Shortest phase [s]; shorter ones are left out.
_BRIEF = 1e-9
_PLAIN = {JointType.REVOLUTE, JointType.CONTINUOUS, JointType.PRISMATIC}


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
    wanted = _input(joints, limits, state, bounds)
    wanted.control_interface = ruckig.ControlInterface.Velocity
    wanted.synchronization = ruckig.Synchronization.No
    wanted.target_velocity = wanted.target_acceleration = [0.0] * len(joints)
    return _solved(joints, wanted)


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
    wanted = _input(joints, limits, state, bounds)
    wanted.target_position = target.q.tolist()
    wanted.target_velocity = target.v.tolist()
    wanted.target_acceleration = target.vdot.tolist()
    return _solved(joints, wanted)


def _input(
    joints: tuple[Joint, ...], limits: JointLimits, state: MotionState, bounds: AccelerationBounds
) -> Any:
    others = [joint.name for joint in joints if joint.type not in _PLAIN]
    if others:
        message = (
            f"joints that shift and turn at once cannot be timed from state to state: {others}"
        )
        raise RetimingFailed(message, {"method": "ruckig", "joints": others})
    wanted = ruckig.InputParameter(len(joints))
    wanted.current_position = state.q.tolist()
    wanted.current_velocity = state.v.tolist()
    wanted.current_acceleration = state.vdot.tolist()
    own = [bounds.get(joint.name, (-np.inf, np.inf)) for joint in joints]
    lowest = np.maximum([low for low, _ in own], -limits.acceleration)
    highest = np.minimum([high for _, high in own], limits.acceleration)
    wanted.min_acceleration = (lowest * _ROOM).tolist()
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = (
        (bound * _ROOM).tolist() for bound in (limits.velocity, highest, limits.jerk)
    )
    return wanted


def _solved(joints: tuple[Joint, ...], wanted: Any) -> TimedTrajectory:
    found = ruckig.Trajectory(len(joints))
    try:
        code = int(ruckig.Ruckig(len(joints), _CYCLE).calculate(wanted, found))
        reason = f"code {code}"
    except ruckig.RuckigError as fault:
        code, reason = -1, str(fault).strip().splitlines()[0]
    if code < 0:
        message = f"ruckig finds no motion between the states: {reason}"
        raise RetimingFailed(message, {"method": "ruckig", "result": reason})
    breaks = _breaks(found, float(found.duration))
    states = np.array([found.at_time(float(t)) for t in breaks])
    q, v, vdot = states[:-1, 0], states[:-1, 1], states[:-1, 2]
    # Jerk is constant on a piece.
    jerk = (states[1:, 2] - vdot) / np.diff(breaks)[:, None]
    coefficients = np.stack([np.zeros_like(q), v, vdot / 2, jerk / 6], axis=1)
    return TimedTrajectory(joints, breaks, q, coefficients)


def _breaks(found: Any, duration: float) -> Array:
    """Return the instants at which a phase of any joint begins, and both ends [s]."""
    instants = [0.0, duration]
    for profile in found.profiles[0]:
        phases = [*profile.brake.t, *profile.t]
        instants += np.cumsum(phases).tolist()
    inside = np.unique([t for t in instants if _BRIEF < t < duration - _BRIEF])
    kept = [0.0]
    for t in inside:
        if t - kept[-1] > _BRIEF:
            kept.append(float(t))
    return np.array([*kept, max(duration, kept[-1] + _BRIEF)])
