"""Path constraints as constraints of Drake's inverse kinematics, where Drake has an equivalent."""

import numpy as np
from pydrake.math import RigidTransform

from planning.goals.ik.group_program import GroupProgram
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Extra tightening of the bounds, larger than the solver's tolerance [m or rad].
_SLACK = 1e-5


def add_constraints(program: GroupProgram, world: World, constraints: PathConstraints) -> None:
    """Add the path constraints of kinds "inside a box" and "cone" to a program.

    Of the other kinds, limits and locked joints are already in the world's limits; constraints to
    stay outside a box, distance bands and predicates have no equivalent in Drake: the caller has
    to check the solution.
    """
    for constraint in constraints.constraints:
        match constraint:
            case BoxConstraint(is_inside=True):
                frame = world.drake.frame(constraint.kinematics.frame)
                half_widths = np.maximum(constraint.half - _SLACK, 0.0)
                program.ik.AddPositionConstraint(
                    frame.frame,
                    frame.origin,
                    world.drake.plant.world_frame(),
                    RigidTransform(constraint.pose.matrix),
                    -half_widths,
                    half_widths,
                )
            case ConeConstraint():
                frame = world.drake.frame(constraint.kinematics.frame)
                program.ik.AddAngleBetweenVectorsConstraint(
                    world.drake.plant.world_frame(),
                    constraint.direction,
                    frame.frame,
                    frame.rotation @ constraint.axis,
                    0.0,
                    max(constraint.tolerance - _SLACK, 0.0),
                )
            case _:
                pass
