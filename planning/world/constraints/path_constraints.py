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
from planning.world.world import CollisionChecker, World

# Shares of a constraint's preferred margin that are tried, the largest first.
_MARGIN_FRACTIONS = (1.0, 0.25)
# A straight step much longer than the width of a band leaves it, in most directions.
_STEP_PER_WIDTH, _MIN_STEP = 2.5, 0.02


@dataclass(frozen=True)
class PathConstraints:
    """Compiled path constraints of a motion.

    Attributes:
        group: Group of the configurations.
        constraints: One compiled constraint for each path constraint, in their order.
        locked: Names of joints that keep their start positions.
    """

    group: JointGroup
    constraints: tuple[CompiledConstraint, ...]
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
        compiled = tuple(compiler.compile_constraint(i, c) for i, c in enumerate(constraints))
        locked_joints = [c.joints for c in constraints if isinstance(c, LockedJoints)]
        return cls(group, compiled, frozenset(name for names in locked_joints for name in names))

    def violations(self, q: Float64[np.ndarray, " nq"]) -> list[dict[str, Any]]:
        """Return the constraints that q, shape (nq,), violates, as evidence."""
        violated = [c for c in self.constraints if not c.are_satisfied(q[None])[0]]
        values = [(constraint.label, constraint.value(q)) for constraint in violated]
        return [
            {
                "constraint": label,
                "value": value.value,
                "bound": value.bound,
                "unit": value.unit,
                **({"joint": value.joint} if value.joint else {}),
            }
            for label, value in values
        ]

    def are_satisfied(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row satisfies every constraint."""
        is_satisfied = np.ones(len(qs), dtype=bool)
        for constraint in self.constraints:
            is_satisfied[is_satisfied] = constraint.are_satisfied(qs[is_satisfied])
        return is_satisfied

    def tightened(
        self, start: Float64[np.ndarray, " nq"], goals: Float64[np.ndarray, "n nq"]
    ) -> "PathConstraints":
        """Return constraints tightened by the largest margins that the start and a goal keep."""
        tightened_constraints: list[CompiledConstraint] = []
        rows = goals
        for constraint in self.constraints:
            chosen = constraint
            for fraction in _MARGIN_FRACTIONS if constraint.preferred_margin > 0 else ():
                candidate = constraint.tightened(fraction * constraint.preferred_margin)
                is_satisfied = candidate.are_satisfied(rows)
                if is_satisfied.any() and candidate.are_satisfied(start[None])[0]:
                    chosen, rows = candidate, rows[is_satisfied]
                    break
            tightened_constraints.append(chosen)
        return replace(self, constraints=tuple(tightened_constraints))

    @property
    def fully_tightened(self) -> "PathConstraints":
        """The constraints tightened by their whole preferred margins, for any start and goals."""
        return replace(
            self,
            constraints=tuple(
                constraint.tightened(constraint.preferred_margin) for constraint in self.constraints
            ),
        )

    def without(self, index: int) -> "PathConstraints":
        """Return all constraints but one."""
        constraints = self.constraints[:index] + self.constraints[index + 1 :]
        lock_flags = [c.locked for c in constraints if isinstance(c, LockConstraint)]
        owners = [joint.name for joint in self.group.joints for _ in joint.velocity_names]
        locked = {
            name
            for flags in lock_flags
            for name, is_locked in zip(owners, flags, strict=True)
            if is_locked
        }
        return replace(self, constraints=constraints, locked=frozenset(locked))

    def oracle(self, inner: CollisionChecker) -> ConstrainedOracle:
        """Return the checker of collisions and constraints."""
        return ConstrainedOracle(inner, Manifold(self.group.joints), self.constraints)

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return position limits intersected with the bounds of the constraints.

        Raises:
            ProblemInvalid: The intersection is empty.
        """
        lower, upper = np.array(limits.lower), np.array(limits.upper)
        for constraint in self.constraints:
            if isinstance(constraint, LimitConstraint):
                lower = np.maximum(lower, constraint.lower)
                upper = np.minimum(upper, constraint.upper)
        empty = [self.group.position_names[i] for i in np.flatnonzero(lower > upper)]
        if empty:
            message = f"path_constraints leave no position of {empty} within the robot's limits"
            raise ProblemInvalid(message, {"field": "path_constraints", "joints": empty})
        return replace(limits, lower=lower, upper=upper)

    def limits_with_locks(self, limits: JointLimits) -> JointLimits:
        """Return `limits` of these constraints with locked joints fixed to one position.

        Floating joints are left free: bounds on a quaternion's components do not bound a rotation.

        Raises:
            ProblemInvalid: The intersection of the limits is empty.
        """
        tight = self.limits(limits)
        lower, upper = np.array(tight.lower), np.array(tight.upper)
        for constraint in self.constraints:
            if isinstance(constraint, LockConstraint):
                fixed = _is_position_of(self.group, self.locked)
                lower[fixed] = upper[fixed] = constraint.start[fixed]
        return replace(tight, lower=lower, upper=upper)

    @property
    def suggested_step(self) -> float:
        """Suggested step of a planner (range), from the thinnest distance band [rad or m]."""
        widths = [
            constraint.max - constraint.min
            for constraint in self.constraints
            if isinstance(constraint, BandConstraint)
        ]
        return max(_STEP_PER_WIDTH * min(widths, default=np.inf), _MIN_STEP)

    @property
    def residual(self) -> ConstraintResidual | None:
        """Residual that projects samples onto sets too thin to be sampled; None if there is none.

        Only for joints that neither wrap nor float: OMPL projects in R^n.
        """
        thin = [
            c
            for c in self.constraints
            if isinstance(c, BoxConstraint | ConeConstraint) and c.is_thin
        ]
        return (
            ConstraintResidual(tuple(thin))
            if thin and Manifold(self.group.joints).is_vector_space
            else None
        )


def _is_position_of(group: JointGroup, names: frozenset[str]) -> Any:
    """Return which coordinates of q are those of some joints, except floating joints."""
    return np.array(
        [
            joint.name in names and joint.type is not JointType.FLOATING
            for joint in group.joints
            for _ in range(joint.num_positions)
        ],
        dtype=bool,
    )
