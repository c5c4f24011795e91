"""Simulation: dynamics of a scene with one group under computed-torque control.

The controller is inverse dynamics with feedback on the acceleration (Siciliano et al., Robotics:
Modelling, Planning and Control, section 8.5.2),

    tau = M(q) (vdot_d + Kd (v_d - v) + Kp (q_d [-] q)) + C(q, v) v - tau_g(q) - tau_damping(v)
          - tau_friction(v_d),

so every joint's error obeys e'' + Kd e' + Kp e = 0 for any mass of the robot, unless the effort
limits clip tau, or dry friction is not that of the desired velocity. It is computed anew in every
step of the plant. Joints that follow the group's are controlled with them; all others are held.
Objects that are held by contact are free bodies, and a force closes their grippers (`Grips`).
"""

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator

from planning.domain.arrays import Array
from planning.domain.geometry.touching_pair import TouchingPair, worst_of_each
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.manifold import Manifold
from planning.domain.scene.held_pose import HeldPose
from planning.errors import ModelInvalid, TrackingLost
from planning.world.mechanics.contact_probe import ContactProbe
from planning.world.mechanics.grips import Grips
from planning.world.mechanics.joint_friction import JointFriction
from planning.world.mechanics.simulation_world import gripped_objects, simulation_world
from planning.world.world import World

# Critically damped: an error dies out within about five times 1 / bandwidth. The product with the
# plant's time step must stay well below 1.
BANDWIDTH = 40.0
CONTACT_DEPTH = 1e-4
# Times after which fingers have closed on what they hold, and it hangs still in them [s].
_CLOSING_TIME, _HANGING_TIME = 0.15, 0.15


class Simulation:
    """Simulation of a group of a world. It owns its context; the world stays as it is.

    The plant has gravity, damping and dry friction of the joints where descriptions state them, and
    effort limits. Not promised: the dynamics of motors or gears; contacts are Drake's compliant
    point contacts. In scenes of more than 48 objects that are fixed to the world, contacts with
    these are detected but exert no force. A half space exerts force within 500 m of its origin and
    down to a depth of 10 m.
    """

    def __init__(
        self,
        world: World,
        group: JointGroup,
        start: Float64[np.ndarray, " nq"],
        *,
        bandwidth: float = BANDWIDTH,
        contact_depth: float = CONTACT_DEPTH,
    ) -> None:
        """Start at time 0 with the group at rest at `start`, all other joints at the world's state.

        Args:
            world: The world; its plant must have a discrete time step.
            group: The group that moves.
            start: The group's q, shape (nq,).
            bandwidth: Of the controller [rad/s].
            contact_depth: Smallest penetration that counts as contact [m].

        Raises:
            ModelInvalid: The robot cannot be simulated: a joint moves no mass, or an object that
                is held by contact has none.
        """
        self.group = group
        limits = world.limits(group)
        held = gripped_objects(world, group)
        world = simulation_world(world, held)
        self._grips = Grips(world, held) if held else None
        self._model = world.drake
        self._block_members, self._effort = _block_members(limits), limits.effort
        self._manifold = Manifold(group.joints)
        self._kp, self._kd = bandwidth**2, 2 * bandwidth
        self._in_q = self._model.position_indices(self.group)
        self._in_v = self._model.velocity_indices(self.group)
        plant = self._model.plant
        self._followers = self._model.followers_of(group)
        self._follower_limits = self._follower_efforts()
        self._forces = MultibodyForces(plant)
        self._root = self._model.diagram.CreateDefaultContext()
        self._context = plant.GetMyMutableContextFromRoot(self._root)
        plant.SetPositions(self._context, self._model.embed(self.group, start, world.state))
        plant.SetVelocities(self._context, np.zeros(plant.num_velocities()))
        # The controller knows the robot, and takes what it holds to be where proofs have it.
        self._known = self._context if not held else plant.CreateDefaultContext()
        inertia = plant.CalcMassMatrix(self._context)
        self._validate_masses(inertia)
        self._friction = JointFriction(world, inertia, plant.time_step())
        self._held_joints = self._hold_others()
        self._tau = plant.get_applied_generalized_force_input_port().FixValue(
            self._context, np.zeros(plant.num_velocities())
        )
        has_static = len(self._model.static_objects) > 0
        probe = world.distance_probe(world.margins()) if has_static else None
        self._contact_probe = ContactProbe(self._model, probe, contact_depth)
        self._simulator = Simulator(self._model.diagram, self._root)
        self._simulator.Initialize()
        self._v_desired = self._vdot_desired = self._error = np.zeros(len(self._in_v))
        self._torques = np.zeros(len(self._in_v))
        if self._grips is not None:
            self._close_on(self._grips)

    @property
    def time(self) -> float:
        """Simulated seconds so far."""
        return float(self._root.get_time())

    @property
    def q(self) -> Array:
        """Measured positions of the group, shape (nq,)."""
        return self.state[self._in_q]

    @property
    def state(self) -> Array:
        """Measured positions of all joints of the scene, shape (num_positions,)."""
        return self._model.plant.GetPositions(self._context)

    def state_of(self, group: JointGroup) -> Array:
        """Return the measured positions of another group, shape (nq,)."""
        return self.state[self._model.position_indices(group)]

    @property
    def v(self) -> Array:
        """Measured velocities of the group, shape (nv,)."""
        return self._model.plant.GetVelocities(self._context)[self._in_v]

    @property
    def torques(self) -> Array:
        """Torques or forces of the group's motors in the last step [N m or N], shape (nv,)."""
        return self._torques

    @property
    def held(self) -> tuple[HeldPose, ...]:
        """Where the objects are that are held by contact."""
        return () if self._grips is None else self._grips.poses(self._context)

    def command(
        self,
        q: Float64[np.ndarray, " nq"],
        v: Float64[np.ndarray, " nv"],
        vdot: Float64[np.ndarray, " nv"],
    ) -> None:
        """Follow q, v, vdot from now on, with vdot held constant until the next command.

        Until then the error is integrated from v_d - v, which is exact but for the curvature of
        rotations: command floating joints every few milliseconds while they turn.
        """
        now = self.q
        tangent = self._manifold.minus(q, now)
        at_base = np.zeros_like(tangent)
        self._error = self._manifold.generalized_velocity(now, at_base, tangent)
        self._v_desired, self._vdot_desired = v, vdot

    def advance_to(self, time: float) -> tuple[TouchingPair, ...]:
        """Simulate until `time` [s]; return pairs in contact at their deepest and largest force.

        Raises:
            TrackingLost: The solver of the contact problem failed: the motion has diverged.
        """
        contacts: list[TouchingPair] = []
        step = self._model.plant.time_step()
        first, last = round(self.time / step), round(time / step)
        for i in range(first + 1, last + 1):
            self._step_to(i * step)
            touching = self._contact_probe.touching(self._context, self.state)
            if touching and self._grips is not None:
                touching = self._grips.counted(touching, self._context)
            contacts += touching
        return worst_of_each(contacts)

    def _close_on(self, grips: Grips) -> None:
        """Close the grippers on what they hold, and let it hang; it is time 0 then."""
        step = self._model.plant.time_step()
        grips.lock(self._context)
        for i in range(1, round((_CLOSING_TIME + _HANGING_TIME) / step) + 1):
            if i == round(_CLOSING_TIME / step):
                grips.unlock(self._context)
            self._step_to(i * step)
        self._root.SetTime(0.0)
        self._simulator.Initialize()

    def _step_to(self, time: float) -> None:
        period = time - self.time
        self._apply_control()
        try:
            self._simulator.AdvanceTo(time)
        except RuntimeError as fault:
            message = f"the simulation diverged at {self.time:.3f} s: {fault}"
            evidence = {"error": None, "bound": None, "time": self.time}
            raise TrackingLost(message, evidence) from fault
        half = 0.5 * period * self._vdot_desired
        self._error = self._error + period * (self._v_desired + half - self.v)
        self._v_desired = self._v_desired + 2 * half

    def _apply_control(self) -> None:
        plant, context = self._model.plant, self._known
        v = plant.GetVelocities(self._context)
        if self._grips is not None:
            plant.SetPositionsAndVelocities(context, plant.GetPositionsAndVelocities(self._context))
            self._grips.hold_still(context)
        vdot = np.zeros(plant.num_velocities())
        feedback = self._kd * (self._v_desired - v[self._in_v]) + self._kp * self._error
        vdot[self._in_v] = self._vdot_desired + feedback
        self._set_other_accelerations(self.state, v, vdot)
        plant.CalcForceElementsContribution(context, self._forces)
        tau = plant.CalcInverseDynamics(context, vdot, self._forces)
        v_desired = np.zeros(len(v))
        v_desired[self._in_v] = self._v_desired
        tau -= self._friction.torques(v_desired)
        tau[self._in_v] *= self._effort_factors(tau[self._in_v])
        followers, bounds = self._follower_limits
        tau[followers] = np.clip(tau[followers], -bounds, bounds)
        if self._grips is not None:
            self._grips.apply(tau)
        self._torques = tau[self._in_v]
        self._tau.GetMutableData().set_value(tau + self._friction.torques(v))

    def _effort_factors(self, tau: Array) -> Array:
        """Return the factors, shape (nv,), that scale every block's norm to its effort limit."""
        norms = np.sqrt(self._block_members @ (tau * tau))
        factors = np.minimum(1.0, self._effort / np.maximum(norms, 1e-12))
        return factors @ self._block_members

    def _follower_efforts(self) -> tuple[list[int], Array]:
        """Return the velocity coordinates of followers, and the limits of their efforts [N m or N].

        One motor moves them with their leader: its limit is theirs, over the multiplier.
        """
        own = np.where(self._block_members > 0, self._effort[:, None], 0.0).max(axis=0)
        limits = dict(zip(self._in_v.tolist(), own.tolist(), strict=True))
        for c in self._followers:
            ratio = abs(c.multiplier)
            leader = limits[c.leader_velocity]
            limits[c.follower_velocity] = leader / ratio if ratio > 0 else np.inf
        found = [c.follower_velocity for c in self._followers]
        return found, np.array([limits[index] for index in found])

    def _set_other_accelerations(self, q: Array, v: Array, vdot: Array) -> None:
        """Set the accelerations of the group's followers, and of the joints that stay."""
        in_q, in_v, targets = self._held_joints
        vdot[in_v] = self._kp * (targets - q[in_q]) - self._kd * v[in_v]
        for c in self._followers:
            target = c.multiplier * q[c.leader_position] + c.offset
            velocity_error = c.multiplier * v[c.leader_velocity] - v[c.follower_velocity]
            error = target - q[c.follower_position]
            leader = c.multiplier * vdot[c.leader_velocity]
            vdot[c.follower_velocity] = leader + self._kd * velocity_error + self._kp * error

    def _hold_others(self) -> tuple[list[int], list[int], Array]:
        """Lock the other planar and floating joints; return the scalar ones and their positions.

        A scalar joint is held by the controller instead: Drake's solver answers NaN for a locked
        joint at its position limit, as in closed grippers.
        """
        controlled = {*self._in_v.tolist(), *(c.follower_velocity for c in self._followers)}
        controlled |= frozenset() if self._grips is None else self._grips.fingers
        plant = self._model.plant
        in_q: list[int] = []
        in_v: list[int] = []
        for index in plant.GetJointIndices():
            joint = plant.get_joint(index)
            if joint.num_velocities() == 0 or joint.velocity_start() in controlled:
                continue
            if joint.num_velocities() == 1:
                in_q.append(joint.position_start())
                in_v.append(joint.velocity_start())
            else:
                joint.Lock(self._context)
        return in_q, in_v, plant.GetPositions(self._context)[in_q]

    def _validate_masses(self, inertia: Array) -> None:
        own = inertia[np.ix_(self._in_v, self._in_v)]
        if not (np.isfinite(own).all() and np.linalg.eigvalsh(own)[0] > 0):
            message = (
                f"group {self.group.name!r} cannot be simulated: its mass matrix is not positive "
            )
            message += "definite, so a joint moves no mass"
            raise ModelInvalid(message, {"file": "", "reason": "massless"})


def _block_members(limits: JointLimits) -> Array:
    """Return the velocity coordinates of each block, as ones, shape (num_blocks, nv)."""
    members = np.zeros((len(limits.blocks), sum(map(len, limits.blocks))))
    for row, block in zip(members, limits.blocks, strict=True):
        row[list(block)] = 1.0
    return members
