"""URScript: a program that sends the samples one after another by servoj."""

from itertools import pairwise

from service.plans.models.trajectory import Trajectory

# How far a joint may be from where the motion begins [rad].
_NEAR = 0.01
# The robot follows the samples through a filter: it looks so far ahead [s], with such a gain.
_LOOKAHEAD = 0.03
_GAIN = 2000
# Deceleration at the end [rad/s^2].
_STOP = 2.0
_HEAD = f"""\
def wayproof_motion():
  local start = {{start}}
  local q = get_actual_joint_positions()
  local i = 0
  while i < 6:
    if norm(q[i] - start[i]) > {_NEAR}:
      popup("the robot is not where the motion begins", "Wayproof", False, True, blocking=True)
      halt
    end
    i = i + 1
  end
"""
_TAIL = f"""\
  stopj({_STOP})
end
"""


def to_urscript(motion: Trajectory) -> bytes:
    """Return the program: it moves to no start by itself, for that motion is not proven."""
    lines = [_HEAD.format(start=_joints(motion.positions[0]))]
    samples = zip(motion.times, motion.positions, strict=True)
    for (before, _), (instant, q) in pairwise(samples):
        step = f"t={instant - before:.6f}, lookahead_time={_LOOKAHEAD}, gain={_GAIN}"
        lines.append(f"  servoj({_joints(q)}, 0, 0, {step})\n")
    return "".join([*lines, _TAIL]).encode()


def _joints(q: list[float]) -> str:
    return f"[{', '.join(f'{number:.9f}' for number in q)}]"
