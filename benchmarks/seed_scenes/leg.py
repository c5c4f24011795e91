"""Leg: one motion of a seed."""

from dataclasses import dataclass

import planning


@dataclass(frozen=True)
class Leg:
    """A motion and the world that it was planned in."""

    world: planning.World
    plan: planning.MotionPlan
