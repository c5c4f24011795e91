"""Links: rigid links of a group as a tree of one-coordinate motions, with their inertia.

All bodies without relative motion are one link. A rigid mass distribution is its pseudo-inertia

    J = integral of [x; 1] [x; 1]^T dm = [[S, h], [h^T, m]],   S = tr(I) / 2 - I,   h = m c,

(Wensing, Kim, Slotine, RA-L 2018), which is transformed into another frame by X J X^T and is
additive. With the eigenvectors e_k and eigenvalues s_k of S about the centre of mass, the angular
momentum about it is sum s_k (R e_k) x (R e_k)': a function of the motion of three points.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.certify.intervals.taylor import skew
from planning.certify.request import CertifyRequest
from planning.certify.torque.joint_motion import JointMotion, JointMotions, MotionKind
from planning.domain.arrays import Array
from planning.errors import ModelInvalid
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True)
class Link:
    """A rigid link: bodies without relative motion.

    Attributes:
        parent: Index of the parent link; -1 is the world.
        X_PF: Pose in its parent at coordinate 0, shape (4, 4).
        motion: Motion relative to the parent.
        inertia: Pseudo-inertia J of its bodies in its own frame, shape (4, 4).
    """

    parent: int
    X_PF: Float64[np.ndarray, "4 4"]
    motion: JointMotion
    inertia: Float64[np.ndarray, "4 4"]

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.inertia[3, 3])

    @property
    def center(self) -> Array:
        """The centre of mass [m], shape (3,); zero without mass."""
        return self.inertia[:3, 3] / self.mass if self.mass > 0 else np.zeros(3)

    @cached_property
    def principal_second_moments(self) -> tuple[Array, Array]:
        """Eigenvalues s_k [kg m^2], shape (3,), and eigenvectors e_k as columns, shape (3, 3)."""
        center = self.center
        return np.linalg.eigh(self.inertia[:3, :3] - self.mass * np.outer(center, center))


def links_of(model: DrakeModel, request: CertifyRequest) -> tuple[Link, ...]:
    """Return the links that the group moves, parents before children.

    Raises:
        ModelInvalid: A joint is of a kind that cannot be certified, or a moving body has no known
            mass.
    """
    return _LinkBuilder(model, request).run()


def chain_to(
    model: DrakeModel, request: CertifyRequest, frame: str
) -> tuple[tuple[Link, ...], Array]:
    """Return the links between the world and a frame, without inertia, and the frame's origin.

    The origin is in the last link, or in the world where there is none [m], shape (3,).

    Raises:
        ModelInvalid: A joint is of a kind that cannot be certified.
    """
    builder = _LinkBuilder(model, request, has_loads=False)
    links, tool = builder.run(), model.frame(frame)
    placement = builder.placements[int(tool.body)]
    way: list[int] = []
    link = placement.link
    while link >= 0:
        way.insert(0, link)
        link = links[link].parent
    chain = tuple(replace(links[index], parent=k - 1) for k, index in enumerate(way))
    return chain, (placement.pose @ _matrix(tool.pose_in_body))[:3, 3]


class _LinkBuilder:
    """One traversal of the model from the world to the tips."""

    def __init__(
        self, model: DrakeModel, request: CertifyRequest, *, has_loads: bool = True
    ) -> None:
        self._model, self._plant, self._payload = model, model.plant, request.payload
        self._has_loads = has_loads
        world = int(model.plant.world_body().index())
        self.placements = {world: _BodyPlacement(-1, np.eye(4))}
        # Parameters are the model's in every context; positions are set here.
        self._context = NearStatic.shared(model).plant_context
        self._plant.SetPositions(self._context, model.apply_couplings(np.array(request.state)))
        self._motions = JointMotions(model, request.group)
        self._rotor_inertias = self._read_rotor_inertias()
        self._links: list[Link] = []

    def run(self) -> tuple[Link, ...]:
        neighbours = self._neighbours()
        pending: list[Any] = [self._plant.world_body()]
        while pending:
            body = pending.pop()
            placement = self.placements[int(body.index())]
            for joint in neighbours.get(int(body.index()), []):
                is_forward = joint.parent_body().index() == body.index()
                other = joint.child_body() if is_forward else joint.parent_body()
                if int(other.index()) not in self.placements:
                    other_placement = self._across_joint(joint, placement, is_forward=is_forward)
                    self.placements[int(other.index())] = other_placement
                    if self._has_loads:
                        self._add_inertia(other, other_placement)
                    pending.append(other)
        return tuple(self._links)

    def _neighbours(self) -> dict[int, list[Any]]:
        joints_of: dict[int, list[Any]] = {}
        for index in self._plant.GetJointIndices():
            joint = self._plant.get_joint(index)
            for body in (joint.parent_body(), joint.child_body()):
                joints_of.setdefault(int(body.index()), []).append(joint)
        return joints_of

    def _across_joint(
        self, joint: Any, placement: "_BodyPlacement", *, is_forward: bool
    ) -> "_BodyPlacement":
        """Return the link and pose of the body beyond a joint."""
        frames = joint.frame_on_parent(), joint.frame_on_child()
        near, far = frames if is_forward else frames[::-1]
        x_near = placement.pose @ _matrix(near.GetFixedPoseInBodyFrame())
        x_far = np.linalg.inv(_matrix(far.GetFixedPoseInBodyFrame()))
        motions = self._motions.of(joint)
        if not motions:
            between = far.CalcPose(self._context, near)
            return _BodyPlacement(placement.link, x_near @ _matrix(between) @ x_far)
        if not is_forward:
            if len(motions) > 1:
                message = (
                    f"joint {joint.name()!r} has several coordinates and its child body is nearer "
                    "to the world than its parent: its torques cannot be certified"
                )
                raise ModelInvalid(message, {"joint": joint.name(), "reason": message})
            motions = [motions[0].reversed]
        link = placement.link
        dampings = self._dampings(joint, motions) if self._has_loads else [0.0] * len(motions)
        for motion, damping in zip(motions, dampings, strict=True):
            rotor_inertia = self._rotor_inertias.get(int(joint.index()), 0.0)
            damped_motion = replace(motion, damping=damping, rotor_inertia=rotor_inertia)
            self._links.append(Link(link, x_near, damped_motion, np.zeros((4, 4))))
            link, x_near = len(self._links) - 1, np.eye(4)
        return _BodyPlacement(link, x_far)

    def _read_rotor_inertias(self) -> dict[int, float]:
        """Return the reflected rotor inertia of every joint with an actuator."""
        actuators = map(self._plant.get_joint_actuator, self._plant.GetJointActuatorIndices())
        return {
            int(actuator.joint().index()): float(actuator.calc_reflected_inertia(self._context))
            for actuator in actuators
        }

    def _dampings(self, joint: Any, motions: list[JointMotion]) -> list[float]:
        """Return the damping of each of a joint's one-coordinate motions."""
        damping = np.array(joint.GetDampingVector(self._context)).tolist()
        if motions[-1].kind is not MotionKind.SPHERICAL:
            return damping
        if any(damping):
            message = f"floating joint {joint.name()!r} has damping: its forces cannot be certified"
            raise ModelInvalid(message, {"joint": joint.name(), "reason": message})
        return [0.0] * len(motions)

    def _add_inertia(self, body: Any, placement: "_BodyPlacement") -> None:
        """Add the inertia of a body, and of its payload, to its link."""
        if placement.link < 0:
            return
        inertia = body.CalcSpatialInertiaInBodyFrame(self._context)
        rotational_inertia = np.array(inertia.CalcRotationalInertia().CopyToFullMatrix3())
        mass, center = float(inertia.get_mass()), np.array(inertia.get_com())
        if not (np.isfinite(mass) and np.isfinite(rotational_inertia).all()):
            message = (
                f"moving body {body.name()!r} has no mass or inertia, so its torques cannot be "
                "certified"
            )
            raise ModelInvalid(message, {"body": body.name(), "reason": message})
        link = self._links[placement.link]
        total = link.inertia + _transformed(
            placement.pose, _pseudo_inertia(mass, center, rotational_inertia)
        )
        if self._payload is not None:
            frame = self._model.frame(self._payload.frame)
            if frame.body == body.index():
                payload = self._payload
                shift = skew(payload.center_of_mass)
                about_frame = payload.inertia - payload.mass * shift @ shift
                x_lf = placement.pose @ _matrix(frame.pose_in_body)
                pseudo = _pseudo_inertia(payload.mass, payload.center_of_mass, about_frame)
                total = total + _transformed(x_lf, pseudo)
        self._links[placement.link] = replace(link, inertia=total)


@dataclass(frozen=True)
class _BodyPlacement:
    """Link of a body, and X_LB, the body's pose in it."""

    link: int
    pose: Array


def _pseudo_inertia(mass: float, center: Array, rotational_inertia: Array) -> Array:
    """Return pseudo-inertia J from mass, centre of mass and rotational inertia about the origin."""
    pseudo = np.zeros((4, 4))
    pseudo[:3, :3] = np.trace(rotational_inertia) / 2 * np.eye(3) - rotational_inertia
    pseudo[:3, 3] = pseudo[3, :3] = mass * center
    pseudo[3, 3] = mass
    return pseudo


def _transformed(pose: Array, pseudo: Array) -> Array:
    return pose @ pseudo @ pose.T


def _matrix(transform: Any) -> Array:
    return np.array(transform.GetAsMatrix4())
