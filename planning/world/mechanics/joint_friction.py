"""JointFriction: dry friction of a simulation's joints, from their descriptions."""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.world.world import World

# Share of the coefficient d at which an explicit step of v' = -d v would oscillate, 2 / time step.
_STABLE_SHARE = 0.25
# Speed from which friction is whole, at least [rad/s or m/s].
_SLIP_SPEED = 1e-3


class JointFriction:
    """Coulomb friction tau = -f clip(v / v_slip, -1, 1) of every scalar joint that states f.

    Below v_slip it is viscous instead of static, so joints creep under a load: v_slip is chosen
    such that explicit steps are stable. Not included: Stribeck's effect, dependence on the load.

    Attributes:
        magnitudes: f of every velocity coordinate of the plant [N m or N], shape (num_velocities,).
    """

    def __init__(self, world: World, inertia: Float64[np.ndarray, "n n"], time_step: float) -> None:
        """Read the friction of all joints.

        Args:
            world: The world.
            inertia: Mass matrix of the plant, positive definite where a joint has friction.
            time_step: Of the simulation [s].
        """
        plant = world.drake.plant
        self.magnitudes = np.zeros(plant.num_velocities())
        for loaded in world.loaded_robots:
            for name, friction in loaded.file.friction.items():
                index = world.drake.joint_indices.get(f"{loaded.scene_robot.name}::{name}")
                if index is not None and plant.get_joint(index).num_velocities() == 1:
                    self.magnitudes[plant.get_joint(index).velocity_start()] = friction
        self._slip_speeds = np.full(len(self.magnitudes), _SLIP_SPEED)
        rough = np.flatnonzero(self.magnitudes)
        if len(rough):
            # What a joint's own torque accelerates while all others are free.
            effective = 1.0 / np.diag(np.linalg.inv(inertia))[rough]
            stable = self.magnitudes[rough] * time_step / (2 * _STABLE_SHARE * effective)
            self._slip_speeds[rough] = np.maximum(_SLIP_SPEED, stable)

    def torques(self, v: Float64[np.ndarray, " n"]) -> Array:
        """Return the torques of friction [N m or N] at the plant's velocities, same shape."""
        return -self.magnitudes * np.clip(v / self._slip_speeds, -1.0, 1.0)
