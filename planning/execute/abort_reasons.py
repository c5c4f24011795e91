"""Reasons to abort an execution: contact, lost tracking, torque limits, lost drivers."""

import numpy as np

from planning.domain.robot.joints import Joint, JointLimits
from planning.domain.scene.held_pose import HeldPose
from planning.errors import Contact, DriverLost, GraspLost, TorqueLimitReached, TrackingLost
from planning.execute.driver import Measurement

# A torque is at its limit from this share of it on.
_SATURATED = 0.999


def contact_failure(measured: Measurement, time: float) -> Contact:
    """Return the failure of the deepest contact, at a time along the trajectory [s]."""
    deepest = measured.contacts[0]
    a, b = deepest.bodies
    depth = -deepest.distance
    force = "" if deepest.force is None else f" with {deepest.force:.1f} N"
    message = f"contact of {a} and {b}, {depth * 1000:.2f} mm deep{force}, at {time:.3f} s"
    evidence = {
        "pair": list(deepest.bodies),
        "depth": depth,
        "force": deepest.force,
        "time": time,
    }
    return Contact(message, evidence)


def grasp_failure(held: HeldPose, time: float) -> GraspLost:
    """Return the failure of an object that slipped, at a time along the trajectory [s]."""
    message = (
        f"{held.name!r} slipped by {1000 * held.slip:.2f} mm in the gripper, where "
        f"{1000 * held.bound:.2f} mm are tolerated, at {time:.3f} s"
    )
    evidence = {"object": held.name, "frame": held.frame, "slip": held.slip, "bound": held.bound}
    return GraspLost(message, {**evidence, "time": time})


def tracking_failure(error: float, bound: float, time: float) -> TrackingLost:
    """Return the failure of a tracking error beyond a bound, at a time along the trajectory."""
    message = f"tracking error {error:.4f} rad or m exceeds {bound:g} at {time:.3f} s"
    return TrackingLost(message, {"error": error, "bound": bound, "time": time})


def saturated_block(measured: Measurement, limits: JointLimits) -> int | None:
    """Return the first block of joints whose torque is at its limit; None without any."""
    if measured.torques is None:
        return None
    for i, (bound, block) in enumerate(zip(limits.effort, limits.blocks, strict=True)):
        if np.linalg.norm(measured.torques[list(block)]) >= _SATURATED * bound:
            return i
    return None


def torque_failure(
    measured: Measurement,
    limits: JointLimits,
    joints: tuple[Joint, ...],
    seconds: float,
    time: float,
) -> TorqueLimitReached:
    """Return the failure of a joint at its torque limit, which it is.

    Args:
        measured: Has its torque.
        limits: Has its limit.
        joints: Of the group.
        seconds: How long some joint has been at its limit [s].
        time: Along the trajectory [s].
    """
    index = saturated_block(measured, limits) or 0
    torques = np.zeros(0) if measured.torques is None else measured.torques
    block = list(limits.blocks[index])
    torque, bound = float(np.linalg.norm(torques[block])), float(limits.effort[index])
    names = [name for joint in joints for name in joint.velocity_names]
    joint = names[block[0]]
    message = (
        f"{joint} was at its torque limit of {bound:g} N m or N for {seconds:.2f} s, "
        f"at {time:.3f} s"
    )
    evidence = {
        "joint": joint,
        "torque": torque,
        "bound": bound,
        "seconds": seconds,
        "time": time,
    }
    return TorqueLimitReached(message, evidence)


def driver_lost(driver: str, reason: str, *, rests: bool) -> DriverLost:
    """Return the failure of a driver.

    Args:
        driver: Its name.
        reason: What happened, as the end of a sentence.
        rests: Whether the robot is known to be at rest where it was last measured.
    """
    state = "the robot rests where it was" if rests else "where the robot is, is not known"
    evidence = {"driver": driver, "reason": reason, "rests": rests}
    return DriverLost(f"the driver {driver!r} is lost: {reason}; {state}", evidence)
