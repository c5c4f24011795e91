"""Path constraints as constraints of Drake's programs, as far as it has any for them."""

import numpy as np
from pydrake.math import RigidTransform

from planning.goals.ik.group_program import GroupProgram
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Demanded beyond the rules, so that what the solver may miss does no harm [m or rad].
_SLACK = 1e-5


def add_constraints(program: GroupProgram, world: World, rules: PathConstraints) -> None:
    """Let a program's solution keep boxes to stay in, and cones.

    Of the others, limits and locked joints are the world's already; staying out of boxes, bands of
    distances and predicates have no constraint: whoever asks judges the solution.
    """
    for rule in rules.rules:
        match rule:
            case BoxConstraint(is_inside=True):
                half = np.maximum(rule.half - _SLACK, 0.0)
                program.ik.AddPositionConstraint(
                    world.drake.frame(rule.motion.frame),
                    np.zeros(3),
                    world.drake.plant.world_frame(),
                    RigidTransform(rule.pose.matrix),
                    -half,
                    half,
                )
            case ConeConstraint():
                program.ik.AddAngleBetweenVectorsConstraint(
                    world.drake.plant.world_frame(),
                    rule.direction,
                    world.drake.frame(rule.motion.frame),
                    rule.axis,
                    0.0,
                    max(rule.tolerance - _SLACK, 0.0),
                )
            case _:
                pass
