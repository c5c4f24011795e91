"""PathRules: all path constraints of one problem, from one start."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain import rotation
from planning.domain.constraint import (
    DistanceBand,
    KeepIn,
    KeepOut,
    LockedJoints,
    OrientationCone,
    PathConstraint,
    PathPredicate,
    PlacedBox,
    PositionBand,
    TightLimits,
    constraint_label,
)
from planning.domain.joints import JointGroup, JointLimits, JointType
from planning.domain.manifold import Manifold
from planning.domain.pose import Pose
from planning.errors import ProblemInvalid
from planning.world.rules.admission import require_constraints
from planning.world.rules.band_rule import BandRule
from planning.world.rules.body_pairs import banded_pairs
from planning.world.rules.box_rule import BoxRule
from planning.world.rules.cone_rule import ConeRule
from planning.world.rules.joint_rules import LimitRule, LockRule
from planning.world.rules.predicate_rule import PredicateRule
from planning.world.rules.residual import RuleResidual
from planning.world.rules.rule import PathRule
from planning.world.rules.ruled_oracle import RuledOracle
from planning.world.tool_kinematics import ToolKinematics
from planning.world.world import CollisionJudge, World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# How much of the room that a rule wishes for is tried, the most first.
_SHARES = (1.0, 0.25)
# A straight step much longer than a band is thick leaves it, in most directions.
_STRIDES, _SHORTEST_STRIDE = 2.5, 0.02


@dataclass(frozen=True)
class PathRules:
    """What a motion shall keep on its whole way.

    Attributes:
        group: Whose configurations are judged.
        rules: One for each constraint, in their order.
        locked: Names of joints that stay where they are.
    """

    group: JointGroup
    rules: tuple[PathRule, ...]
    locked: frozenset[str]

    @classmethod
    def compiled(
        cls,
        world: World,
        group: JointGroup,
        constraints: tuple[PathConstraint, ...],
        start: Float64[np.ndarray, " nq"],
    ) -> "PathRules":
        """Make the rules; frames and joints count where the start, shape (nq,), has them.

        Raises:
            UnknownName: A body, frame or joint does not exist.
            ProblemInvalid: A number makes no sense.
        """
        require_constraints(world, group, constraints)
        compiler = _Compiler(world, group, start)
        rules = tuple(compiler.rule(i, c) for i, c in enumerate(constraints))
        locks = [c.joints for c in constraints if isinstance(c, LockedJoints)]
        return cls(group, rules, frozenset(name for names in locks for name in names))

    def violations(self, q: Float64[np.ndarray, " nq"]) -> list[dict[str, Any]]:
        """Return the rules that q, shape (nq,), violates, as evidence."""
        broken = [rule for rule in self.rules if not rule.are_kept(q[None])[0]]
        readings = [(rule.label, rule.reading(q)) for rule in broken]
        return [
            {
                "constraint": label,
                "value": reading.value,
                "bound": reading.bound,
                "unit": reading.unit,
                **({"joint": reading.joint} if reading.joint else {}),
            }
            for label, reading in readings
        ]

    def are_kept(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row keeps every rule."""
        kept = np.ones(len(qs), dtype=bool)
        for rule in self.rules:
            kept[kept] = rule.are_kept(qs[kept])
        return kept

    def leaving_room(
        self, start: Float64[np.ndarray, " nq"], goals: Float64[np.ndarray, "n nq"]
    ) -> "PathRules":
        """Return rules that demand a little more, as far as the start and a goal have it."""
        rules: list[PathRule] = []
        rows = goals
        for rule in self.rules:
            chosen = rule
            for share in _SHARES if rule.wish > 0 else ():
                wished = rule.leaving(share * rule.wish)
                kept = wished.are_kept(rows)
                if kept.any() and wished.are_kept(start[None])[0]:
                    chosen, rows = wished, rows[kept]
                    break
            rules.append(chosen)
        return replace(self, rules=tuple(rules))

    @property
    def roomy(self) -> "PathRules":
        """The rules with all the room that they wish for, whatever start and goals have."""
        return replace(self, rules=tuple(rule.leaving(rule.wish) for rule in self.rules))

    def without(self, index: int) -> "PathRules":
        """Return all rules but one."""
        rules = self.rules[:index] + self.rules[index + 1 :]
        held = [rule.locked for rule in rules if isinstance(rule, LockRule)]
        owners = [joint.name for joint in self.group.joints for _ in joint.velocity_names]
        locked = {
            name for flags in held for name, is_held in zip(owners, flags, strict=True) if is_held
        }
        return replace(self, rules=rules, locked=frozenset(locked))

    def oracle(self, inner: CollisionJudge) -> RuledOracle:
        """Return the judge of collisions and rules."""
        return RuledOracle(inner, Manifold(self.group.joints), self.rules)

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return position limits with the tighter ones of the rules.

        Raises:
            ProblemInvalid: Nothing is left between them.
        """
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        for rule in self.rules:
            if isinstance(rule, LimitRule):
                lower, upper = np.maximum(lower, rule.lower), np.minimum(upper, rule.upper)
        empty = [self.group.position_names[i] for i in np.flatnonzero(lower > upper)]
        if empty:
            message = f"path_constraints leave no position for {empty} within the robot's limits"
            raise ProblemInvalid(message, {"field": "path_constraints", "joints": empty})
        return replace(limits, lower=lower, upper=upper)

    def fixing(self, limits: JointLimits) -> JointLimits:
        """Return `limits` of these rules in which locked joints have but one position.

        Joints that float are left free: bounds on a quaternion's numbers say nothing of a rotation.

        Raises:
            ProblemInvalid: Nothing is left between the limits.
        """
        tight = self.limits(limits)
        lower, upper = np.array(tight.lower), np.array(tight.upper)
        for rule in self.rules:
            if isinstance(rule, LockRule):
                fixed = _positions_of(self.group, self.locked)
                lower[fixed] = upper[fixed] = rule.start[fixed]
        return replace(tight, lower=lower, upper=upper)

    @property
    def stride(self) -> float:
        """How far a planner should step at once, the thinnest band considered [rad or m]."""
        widths = [rule.max - rule.min for rule in self.rules if isinstance(rule, BandRule)]
        return max(_STRIDES * min(widths, default=np.inf), _SHORTEST_STRIDE)

    @property
    def residual(self) -> RuleResidual | None:
        """What brings a sample onto sets too thin to be sampled; None if there is none.

        Only for joints that neither wrap nor float: OMPL projects in R^n.
        """
        thin = [r for r in self.rules if isinstance(r, BoxRule | ConeRule) and r.is_thin]
        return RuleResidual(tuple(thin)) if thin and Manifold(self.group.joints).is_vector else None


def _positions_of(group: JointGroup, names: frozenset[str]) -> Any:
    """Return which coordinates of q are those of some joints, but for joints that float."""
    return np.array(
        [
            joint.name in names and joint.type is not JointType.FLOATING
            for joint in group.joints
            for _ in range(joint.num_positions)
        ],
        dtype=bool,
    )


@dataclass(frozen=True)
class _Compiler:
    """What rules are made of."""

    world: World
    group: JointGroup
    start: Array

    def rule(self, index: int, constraint: PathConstraint) -> PathRule:
        label = constraint_label(index, constraint)
        match constraint:
            case DistanceBand():
                pairs = banded_pairs(
                    self.world, self.group, constraint, f"path_constraints.{index}"
                )
                return BandRule(
                    label, self.world, self.group, pairs, constraint.min, constraint.max
                )
            case KeepOut() | KeepIn() | PositionBand():
                motion = ToolKinematics(self.world, self.group, constraint.frame)
                is_inside = not isinstance(constraint, KeepOut)
                half = constraint.box.size / 2
                return BoxRule(label, motion, self._box_pose(constraint.box), half, is_inside)
            case OrientationCone():
                return self._cone(label, constraint)
            case LockedJoints() | TightLimits():
                return self._joints(label, constraint)
            case PathPredicate():
                name = f"{label} {constraint.name}".removesuffix(" predicate")
                return PredicateRule(name, constraint.predicate, constraint.resolution)

    def _reference(self, name: str) -> Pose:
        return self.world.frame_pose(name, self.world.embed(self.group, self.start))

    def _box_pose(self, box: PlacedBox) -> Pose:
        return self._reference(box.reference) @ box.pose

    def _cone(self, label: str, cone: OrientationCone) -> ConeRule:
        turn = rotation.matrix(self._reference(cone.reference).quaternion)
        direction = turn @ cone.direction
        return ConeRule(
            label,
            ToolKinematics(self.world, self.group, cone.frame),
            cone.axis / np.linalg.norm(cone.axis),
            direction / np.linalg.norm(direction),
            cone.tolerance,
        )

    def _joints(self, label: str, constraint: LockedJoints | TightLimits) -> PathRule:
        joints = self.group.joints
        if isinstance(constraint, LockedJoints):
            flags = [j.name in constraint.joints for j in joints for _ in range(j.num_velocities)]
            locked = np.array(flags, dtype=bool)
            return LockRule(label, Manifold(joints), self.start, locked, self.group.velocity_names)
        lower = np.full(self.group.num_positions, -np.inf)
        upper, circle = -lower, np.zeros(len(lower), dtype=bool)
        names = self.group.position_names
        for name, (low, high) in constraint.limits.items():
            lower[names.index(name)], upper[names.index(name)] = low, high
        iq = 0
        for joint in joints:
            if any(joint.wraps):
                circle[iq : iq + joint.num_positions] = joint.wraps
            iq += joint.num_positions
        return LimitRule(label, lower, upper, circle, names)
