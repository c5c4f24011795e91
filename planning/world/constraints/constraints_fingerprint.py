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
from planning.world.fingerprint import probes
from planning.world.mechanics.tool_kinematics import ToolKinematics


def constraints_fingerprint(rules: PathConstraints) -> str:
    """Return the sha256 of all constraints, their margins included.

    Raises:
        ProblemInvalid: One is a predicate, which has no content to digest.
    """
    return digest([_told(rule, rules.group) for rule in rules.rules])


def _told(rule: CompiledConstraint, group: JointGroup) -> list[Any]:
    match rule:
        case BandConstraint():
            pairs = [list(pair) for pair in sorted(rule.pairs)]
            return ["band", pairs, rule.min, rule.max, rule.room]
        case BoxConstraint():
            box = [rule.pose, rule.half, rule.is_inside, rule.room]
            return ["box", *_motion(rule.motion, group), *box]
        case ConeConstraint():
            cone = [rule.axis, rule.direction, rule.tolerance, rule.room]
            return ["cone", *_motion(rule.motion, group), *cone]
        case LockConstraint():
            return ["lock", *_locked(rule, group)]
        case LimitConstraint():
            return ["limits", rule.lower, rule.upper]
        case PredicateConstraint():
            raise predicates_refused(rule.label)
        case _:
            raise TypeError(rule.label)


def predicates_refused(label: str) -> ProblemInvalid:
    """Return the error for a predicate in a request for a stored roadmap."""
    field = "search.roadmap"
    message = (
        f"{field}: {label}: a stored roadmap is identified by its constraints, and a "
        f"{PathPredicate.__name__} is a function without a digest; plan without one of them"
    )
    return ProblemInvalid(message, {"field": field, "constraint": label})


def _motion(motion: ToolKinematics, group: JointGroup) -> list[Any]:
    """Return the pose of a frame on its body: the frame's name does not determine it."""
    return list(motion.poses(probes(group)))


def _locked(rule: LockConstraint, group: JointGroup) -> list[Any]:
    """Return the locked coordinates and their values."""
    found: list[Any] = []
    iq = iv = 0
    for joint in group.joints:
        if rule.locked[iv : iv + joint.num_velocities].any():
            found.append([joint.name, np.array(rule.start[iq : iq + joint.num_positions])])
        iq += joint.num_positions
        iv += joint.num_velocities
    return found
