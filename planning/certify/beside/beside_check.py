"""Beside check: two motions keep their margins whatever their timing, proven on both intervals.

A combined motion holds for one timing. Executions that are started, paused, slowed and driven
backwards one by one have any timing, so here the times are independent: for every instant t of the
first motion and every instant s of the second, each pair of a body A that the first moves and a
body B that the second moves keeps its margin m.

The rectangle of all (t, s) is covered by nodes, a segment of either motion, with the centres t_m
and s_m. On a node a point of A moves by at most delta_A from its place at t_m, and one of B by at
most delta_B from its place at s_m (`motion_bounds`: the sum over the joints that carry the shape of
2 sin(a / 2) rho, with lever arms at the centres). A does not depend on s, nor B on t. So

    d(A(t), B(s)) >= d(A(t_m), B(s_m)) - delta_A - delta_B,

and the pair is proven on the node if the right side is above m. The kernel adds its bound of second
order: the width of a slab between both (motion_bounds.hpp), over the product of the sets of joint
displacements on both segments; that allows much longer segments. Pairs that a node leaves open are
bounded again on both halves of the motion with the larger share, the node with the smallest bound
first. A node at whose centre a pair violates its margin refuses at once, by two configurations that
both motions pass through. Where neither holds on segments of 1e-7 s, or after very many nodes, the
motions are refused as undecided.
"""

from planning.certify.beside.beside_request import BesideRequest, BesideResult
from planning.certify.beside.drake_beside import DrakeBeside
from planning.certify.beside.native_beside import native_beside
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel
from planning.world.kernel.kernel_scene import kernel_scene_of


def check_beside(model: DrakeModel, request: BesideRequest, deadline: Deadline) -> BesideResult:
    """Prove, or fail to prove, that two motions keep their margins whatever their timing.

    Raises:
        DeadlineExceeded: Time ran out; nothing is proven.
        Canceled: The caller canceled.
        ModelInvalid: A shape or joint of a kind that cannot be certified.
    """
    scene = kernel_scene_of(model)
    if scene is not None:
        return native_beside(scene, model, request, deadline)
    return DrakeBeside(model, request, deadline).run()
