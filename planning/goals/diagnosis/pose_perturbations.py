"""PosePerturbations: random configurations around a feasible one, biased towards a tool pose."""

import numpy as np
from jaxtyping import Float64

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.goals.diagnosis.joint_perturbations import JointPerturbations
from planning.goals.joint_metric import JointMetric
from planning.world.mechanics.tool_kinematics import ToolKinematics
from planning.world.world import World

# Configurations per draw.
_NUM_SAMPLES = 320
# Singular values below this share of the largest count as zero.
_RCOND = 1e-3
# Largest scale of the joint displacements [rad or m].
_MAX_SCALE = 1.0


class PosePerturbations:
    """Sampler of joint displacements: random ones plus steps of the tool towards a pose.

    Sizes are spread over orders of magnitude. It needs no inverse kinematics, so it works for every
    group, and its random part moves along active constraints.
    """

    def __init__(
        self, world: World, group: JointGroup, frame: str, rng: np.random.Generator
    ) -> None:
        """Prepare for a group and its tool frame."""
        self._limits = world.limits(group)
        self._manifold = Manifold(group.joints)
        self._kinematics = ToolKinematics(world, group, frame)
        self._perturbations = JointPerturbations(group, JointMetric(self._manifold, None), rng)

    def sample(self, q: Float64[np.ndarray, " nq"], desired: Pose) -> Float64[np.ndarray, "n nq"]:
        """Return configurations within limits: q displaced at random and towards a pose X_WT."""
        full_step = minimum_norm_step(self._kinematics, q, desired)
        radius = min(float(np.linalg.norm(full_step)), _MAX_SCALE)
        fractions = 10 ** (-4 * np.linspace(0.0, 1.0, _NUM_SAMPLES))[:, None]
        displacements = (
            self._perturbations.sample_multiscale(max(radius, 1e-6), _NUM_SAMPLES)
            + fractions * full_step
        )
        rows = self._manifold.normalized(self._manifold.plus(q[None], displacements))
        return np.clip(rows, self._limits.lower, self._limits.upper)


def minimum_norm_step(
    kinematics: ToolKinematics, q: Float64[np.ndarray, " nq"], desired: Pose
) -> Float64[np.ndarray, " nv"]:
    """Return the minimum-norm tangent at q that moves the tool to a pose X_WT, to first order."""
    R_WT, p = (part[0] for part in kinematics.poses(q[None]))
    inverse = rotation.conjugate(rotation.from_matrix(R_WT))
    turn = rotation.log(rotation.multiply(desired.quaternion, inverse))
    twist = np.concatenate([turn, desired.position - p])
    jacobian = kinematics.jacobians(q[None])[0]
    return np.asarray(np.linalg.lstsq(jacobian, twist, rcond=_RCOND)[0])
