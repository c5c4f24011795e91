"""Constraints fingerprint: digest of compiled path constraints.

Where constraints with the same fingerprint hold in worlds with the same one (`world.fingerprint`),
the same configurations satisfy them. Data that constraints take from the start (a frame that moves
with the group, locked joints) enters the digest, the rest of the start does not.
"""

from typing import Any

import numpy as np

from planning.domain.request.constraint import PathPredicate
from planning.domain.robot.joints import JointGroup
from planning.domain.value import digest
from planning.errors import ProblemInvalid
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.joint_constraints import LimitConstraint, LockConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.constraints.predicate_constraint import PredicateConstraint
from planning.world.fingerprint import probe_configurations
from planning.world.mechanics.tool_kinematics import ToolKinematics


def constraints_fingerprint(constraints: PathConstraints) -> str:
    """Return the sha256 of all constraints, their margins included.

    Raises:
        ProblemInvalid: One is a predicate, which has no content to digest.
    """
    return digest([
        _constraint_content(constraint, constraints.group) for constraint in constraints.constraints
    ])


def _constraint_content(constraint: CompiledConstraint, group: JointGroup) -> list[Any]:
    match constraint:
        case BandConstraint():
            pairs = [list(pair) for pair in sorted(constraint.pairs)]
            return ["band", pairs, constraint.min, constraint.max, constraint.margin]
        case BoxConstraint():
            box = [constraint.pose, constraint.half, constraint.is_inside, constraint.margin]
            return ["box", *_frame_content(constraint.kinematics, group), *box]
        case ConeConstraint():
            cone = [constraint.axis, constraint.direction, constraint.tolerance, constraint.margin]
            return ["cone", *_frame_content(constraint.kinematics, group), *cone]
        case LockConstraint():
            return ["lock", *_locked_content(constraint, group)]
        case LimitConstraint():
            return ["limits", constraint.lower, constraint.upper]
        case PredicateConstraint():
            raise predicate_error(constraint.label)
        case _:
            raise TypeError(constraint.label)


def predicate_error(label: str) -> ProblemInvalid:
    """Return the error for a predicate in a request for a stored roadmap."""
    field = "search.roadmap"
    message = (
        f"{field}: {label}: a stored roadmap is identified by its constraints, and a "
        f"{PathPredicate.__name__} is a function without a digest; omit one of them"
    )
    return ProblemInvalid(message, {"field": field, "constraint": label})


def _frame_content(kinematics: ToolKinematics, group: JointGroup) -> list[Any]:
    """Return the pose of a frame on its body: the frame's name does not determine it."""
    return list(kinematics.poses(probe_configurations(group)))


def _locked_content(constraint: LockConstraint, group: JointGroup) -> list[Any]:
    """Return the locked coordinates and their values."""
    content: list[Any] = []
    iq = iv = 0
    for joint in group.joints:
        if constraint.locked[iv : iv + joint.num_velocities].any():
            content.append([joint.name, np.array(constraint.start[iq : iq + joint.num_positions])])
        iq += joint.num_positions
        iv += joint.num_velocities
    return content
