"""Simulation: dynamics of a scene with one group under computed-torque control.

The controller is inverse dynamics with feedback on the acceleration (Siciliano et al., Robotics:
Modelling, Planning and Control, section 8.5.2),

    tau = M(q) (vdot_d + Kd (v_d - v) + Kp (q_d [-] q)) + C(q, v) v - tau_g(q) - tau_damping(v),

so every joint's error obeys e'' + Kd e' + Kp e = 0 for any mass of the robot, unless the effort
limits clip tau. Joints that follow the group's are controlled with them; all others are held.
"""

from typing import Any

import numpy as np
from jaxtyping import Float64
from pydrake.multibody.plant import PointPairContactInfo
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator

from planning.domain.arrays import Array
from planning.domain.geometry.body_pair import BodyPair
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.manifold import Manifold
from planning.errors import ModelInvalid, TrackingLost
from planning.world.world import World

# Critically damped: an error dies out within about five times 1 / bandwidth. The product with the
# plant's time step must stay well below 1.
BANDWIDTH = 40.0
CONTACT_DEPTH = 1e-4


class Simulation:
    """Simulation of a group of a world. It owns its context; the world stays as it is.

    Not promised: joint friction, motors or gears; contacts are Drake's compliant point contacts.
    Contacts with objects outside of Drake's model, in scenes of many objects, are detected but
    exert no force.
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
            ModelInvalid: The robot cannot be simulated: a joint moves no mass.
        """
        self.group = group
        self._model = world.drake
        limits = world.limits(group)
        self._block_members, self._effort = _block_members(limits), limits.effort
        self._manifold = Manifold(group.joints)
        self._kp, self._kd, self._contact_depth = bandwidth**2, 2 * bandwidth, contact_depth
        self._in_q = self._model.position_indices(self.group)
        self._in_v = self._model.velocity_indices(self.group)
        plant = self._model.plant
        self._followers = self._model.followers_of(group)
        self._forces = MultibodyForces(plant)
        self._root = self._model.diagram.CreateDefaultContext()
        self._context = plant.GetMyMutableContextFromRoot(self._root)
        plant.SetPositions(self._context, self._model.embed(self.group, start, world.state))
        plant.SetVelocities(self._context, np.zeros(plant.num_velocities()))
        self._validate_masses()
        self._held_joints = self._hold_others()
        self._tau = plant.get_applied_generalized_force_input_port().FixValue(
            self._context, np.zeros(plant.num_velocities())
        )
        self._static_probe = (
            world.distance_probe(world.margins()) if len(self._model.static_objects) else None
        )
        self._simulator = Simulator(self._model.diagram, self._root)
        self._simulator.Initialize()
        self._v_desired = self._vdot_desired = self._error = np.zeros(len(self._in_v))

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

    @property
    def v(self) -> Array:
        """Measured velocities of the group, shape (nv,)."""
        return self._model.plant.GetVelocities(self._context)[self._in_v]

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

    def advance_to(self, time: float) -> tuple[BodyPair, ...]:
        """Simulate until `time` [s] and return the bodies in contact, each pair at its deepest.

        Raises:
            TrackingLost: The solver of the contact problem failed: the motion has diverged.
        """
        deepest: dict[tuple[str, str], BodyPair] = {}
        step = self._model.plant.time_step()
        first, last = round(self.time / step), round(time / step)
        for i in range(first + 1, last + 1):
            self._step_to(i * step)
            for pair in self._contacts():
                known = deepest.get(pair.bodies)
                if known is None or pair.distance < known.distance:
                    deepest[pair.bodies] = pair
        return tuple(sorted(deepest.values(), key=lambda pair: pair.distance))

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
        plant, context = self._model.plant, self._context
        v = plant.GetVelocities(context)
        vdot = np.zeros(plant.num_velocities())
        feedback = self._kd * (self._v_desired - v[self._in_v]) + self._kp * self._error
        vdot[self._in_v] = self._vdot_desired + feedback
        self._set_other_accelerations(plant.GetPositions(context), v, vdot)
        plant.CalcForceElementsContribution(context, self._forces)
        tau = plant.CalcInverseDynamics(context, vdot, self._forces)
        tau[self._in_v] *= self._effort_factors(tau[self._in_v])
        self._tau.GetMutableData().set_value(tau)

    def _effort_factors(self, tau: Array) -> Array:
        """Return the factors, shape (nv,), that scale every block's norm to its effort limit."""
        norms = np.sqrt(self._block_members @ (tau * tau))
        factors = np.minimum(1.0, self._effort / np.maximum(norms, 1e-12))
        return factors @ self._block_members

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

    def _contacts(self) -> list[BodyPair]:
        port: Any = self._model.plant.get_contact_results_output_port()
        results = port.Eval(self._context)
        infos = [
            results.point_pair_contact_info(i) for i in range(results.num_point_pair_contacts())
        ]
        touching = [
            self._body_pair(info) for info in infos if info.point_pair().depth > self._contact_depth
        ]
        return touching + self._static_contacts()

    def _static_contacts(self) -> list[BodyPair]:
        """Return contacts with objects outside of Drake's model, which exert no force."""
        if self._static_probe is None:
            return []
        rows = self._model.static_objects.rows
        return [
            pair
            for pair in self._static_probe.pairs_within(self.state, -self._contact_depth)
            if not rows.keys().isdisjoint(pair.bodies)
        ]

    def _body_pair(self, info: PointPairContactInfo) -> BodyPair:
        pair = info.point_pair()
        names = self._model.body_names
        sides = [
            (names[info.bodyA_index()], pair.p_WCa),
            (names[info.bodyB_index()], pair.p_WCb),
        ]
        (a, p_wa), (b, p_wb) = sorted(sides, key=lambda side: side[0])
        return BodyPair((a, b), -float(pair.depth), np.array([p_wa, p_wb]))

    def _hold_others(self) -> tuple[list[int], list[int], Array]:
        """Lock the other planar and floating joints; return the scalar ones and their positions.

        A scalar joint is held by the controller instead: Drake's solver answers NaN for a locked
        joint at its position limit, as in closed grippers.
        """
        controlled = {*self._in_v.tolist(), *(c.follower_velocity for c in self._followers)}
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

    def _validate_masses(self) -> None:
        inertia = self._model.plant.CalcMassMatrix(self._context)
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
