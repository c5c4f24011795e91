"""PathConstraints: all path constraints of one problem, compiled from one start."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.request.constraint import (
    LockedJoints,
    PathConstraint,
)
from planning.domain.robot.joints import JointGroup, JointLimits, JointType
from planning.domain.robot.manifold import Manifold
from planning.errors import ProblemInvalid
from planning.world.constraints.band_constraint import BandConstraint
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.compiled_constraint import CompiledConstraint
from planning.world.constraints.cone_constraint import ConeConstraint
from planning.world.constraints.constrained_oracle import ConstrainedOracle
from planning.world.constraints.constraint_compiler import ConstraintCompiler
from planning.world.constraints.constraint_residual import ConstraintResidual
from planning.world.constraints.joint_constraints import LimitConstraint, LockConstraint
from planning.world.constraints.validate_constraints import validate_constraints
from planning.world.world import CollisionJudge, World

# Shares of a constraint's preferred margin that are tried, the largest first.
_SHARES = (1.0, 0.25)
# A straight step much longer than a band is thick leaves it, in most directions.
_STRIDES, _SHORTEST_STRIDE = 2.5, 0.02


@dataclass(frozen=True)
class PathConstraints:
    """Compiled path constraints of a motion.

    Attributes:
        group: Group of the configurations.
        rules: One compiled constraint for each path constraint, in their order.
        locked: Names of joints that keep their start positions.
    """

    group: JointGroup
    rules: tuple[CompiledConstraint, ...]
    locked: frozenset[str]

    @classmethod
    def compiled(
        cls,
        world: World,
        group: JointGroup,
        constraints: tuple[PathConstraint, ...],
        start: Float64[np.ndarray, " nq"],
    ) -> "PathConstraints":
        """Compile the constraints; frames and joints are taken at the start, shape (nq,).

        Raises:
            UnknownName: A body, frame or joint does not exist.
            ProblemInvalid: A number is invalid.
        """
        validate_constraints(world, group, constraints)
        compiler = ConstraintCompiler(world, group, start)
        rules = tuple(compiler.rule(i, c) for i, c in enumerate(constraints))
        locks = [c.joints for c in constraints if isinstance(c, LockedJoints)]
        return cls(group, rules, frozenset(name for names in locks for name in names))

    def violations(self, q: Float64[np.ndarray, " nq"]) -> list[dict[str, Any]]:
        """Return the constraints that q, shape (nq,), violates, as evidence."""
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
        """Return whether each row satisfies every constraint."""
        kept = np.ones(len(qs), dtype=bool)
        for rule in self.rules:
            kept[kept] = rule.are_kept(qs[kept])
        return kept

    def leaving_room(
        self, start: Float64[np.ndarray, " nq"], goals: Float64[np.ndarray, "n nq"]
    ) -> "PathConstraints":
        """Return constraints tightened by the largest margins that the start and a goal keep."""
        rules: list[CompiledConstraint] = []
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
    def roomy(self) -> "PathConstraints":
        """The constraints tightened by their whole preferred margins, for any start and goals."""
        return replace(self, rules=tuple(rule.leaving(rule.wish) for rule in self.rules))

    def without(self, index: int) -> "PathConstraints":
        """Return all constraints but one."""
        rules = self.rules[:index] + self.rules[index + 1 :]
        held = [rule.locked for rule in rules if isinstance(rule, LockConstraint)]
        owners = [joint.name for joint in self.group.joints for _ in joint.velocity_names]
        locked = {
            name for flags in held for name, is_held in zip(owners, flags, strict=True) if is_held
        }
        return replace(self, rules=rules, locked=frozenset(locked))

    def oracle(self, inner: CollisionJudge) -> ConstrainedOracle:
        """Return the checker of collisions and constraints."""
        return ConstrainedOracle(inner, Manifold(self.group.joints), self.rules)

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return position limits intersected with the bounds of the constraints.

        Raises:
            ProblemInvalid: The intersection is empty.
        """
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        for rule in self.rules:
            if isinstance(rule, LimitConstraint):
                lower, upper = np.maximum(lower, rule.lower), np.minimum(upper, rule.upper)
        empty = [self.group.position_names[i] for i in np.flatnonzero(lower > upper)]
        if empty:
            message = f"path_constraints leave no position for {empty} within the robot's limits"
            raise ProblemInvalid(message, {"field": "path_constraints", "joints": empty})
        return replace(limits, lower=lower, upper=upper)

    def fixing(self, limits: JointLimits) -> JointLimits:
        """Return `limits` of these constraints with locked joints fixed to one position.

        Floating joints are left free: bounds on a quaternion's components do not bound a rotation.

        Raises:
            ProblemInvalid: The intersection of the limits is empty.
        """
        tight = self.limits(limits)
        lower, upper = np.array(tight.lower), np.array(tight.upper)
        for rule in self.rules:
            if isinstance(rule, LockConstraint):
                fixed = _positions_of(self.group, self.locked)
                lower[fixed] = upper[fixed] = rule.start[fixed]
        return replace(tight, lower=lower, upper=upper)

    @property
    def stride(self) -> float:
        """Suggested step of a planner (range), from the thinnest distance band [rad or m]."""
        widths = [rule.max - rule.min for rule in self.rules if isinstance(rule, BandConstraint)]
        return max(_STRIDES * min(widths, default=np.inf), _SHORTEST_STRIDE)

    @property
    def residual(self) -> ConstraintResidual | None:
        """Residual that projects samples onto sets too thin to be sampled; None if there is none.

        Only for joints that neither wrap nor float: OMPL projects in R^n.
        """
        thin = [
            r for r in self.rules if isinstance(r, BoxConstraint | ConeConstraint) and r.is_thin
        ]
        return (
            ConstraintResidual(tuple(thin))
            if thin and Manifold(self.group.joints).is_vector
            else None
        )


def _positions_of(group: JointGroup, names: frozenset[str]) -> Any:
    """Return which coordinates of q are those of some joints, except floating joints."""
    return np.array(
        [
            joint.name in names and joint.type is not JointType.FLOATING
            for joint in group.joints
            for _ in range(joint.num_positions)
        ],
        dtype=bool,
    )
