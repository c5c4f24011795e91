"""FrameChain: the joints of a group between the world and a frame, with the distances between."""

from dataclasses import dataclass

import numpy as np

from planning.certify.clearance.motion_bounds import MovingJoint, joint_chains, moving_joints
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.world.collision.near_static import NearStatic
from planning.world.drake_model import DrakeModel


@dataclass(frozen=True)
class ChainLink:
    """A joint of the chain, and its distance to the next joint or to the frame [m]."""

    joint: MovingJoint
    length: float


def chain_links(model: DrakeModel, request: CertifyRequest, name: str) -> list[ChainLink]:
    """Return the chain of joints between the world and a frame, in order."""
    moving = moving_joints(model, request.group)
    chains = joint_chains(model, moving)
    context = NearStatic.shared(model).plant_context
    full = model.embed(request.group, request.reference, request.state)
    model.plant.SetPositions(context, full)
    frame = model.frame(name)
    ends = list[tuple[int, MovingJoint, Array, Array]]()
    for k in chains[int(frame.body)]:
        joint = moving[k].joint
        near, far = joint.frame_on_parent(), joint.frame_on_child()
        # Drake may run a joint from the tip to the base.
        if k not in chains[int(joint.child_body().index())]:
            near, far = far, near
        rank = len(chains[int(far.body().index())])
        positions = [np.array(f.CalcPoseInWorld(context).translation()) for f in (near, far)]
        ends.append((rank, moving[k], positions[0], positions[1]))
    ends.sort(key=lambda entry: entry[0])
    tip = np.array(frame.pose(context).translation())
    # Without a joint between world and frame the frame does not move.
    nexts = [near for _, _, near, _ in ends[1:]] + [tip] * bool(ends)
    return [
        ChainLink(joint, float(np.linalg.norm(there - far)))
        for (_, joint, _, far), there in zip(ends, nexts, strict=True)
    ]
