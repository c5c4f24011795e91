"""ContactProbe: bodies in contact in a simulation, with the forces between them."""

from typing import Any

import numpy as np
from pydrake.multibody.plant import PointPairContactInfo

from planning.domain.arrays import Array
from planning.domain.geometry.touching_pair import TouchingPair
from planning.world.collision.collision_check import DistanceProbe
from planning.world.drake_model import DrakeModel


class ContactProbe:
    """Reads the contacts of a plant's context.

    In scenes of many objects, contacts with those outside of Drake's model exert no force.
    """

    def __init__(self, model: DrakeModel, probe: DistanceProbe | None, depth: float) -> None:
        """Take the parts of a simulation.

        Args:
            model: The scene.
            probe: Of distances to the objects outside of Drake's model; None without any.
            depth: Smallest penetration that counts as contact [m].
        """
        self._model = model
        self._probe = probe
        self._depth = depth

    def touching(self, context: Any, state: Array) -> list[TouchingPair]:
        """Return the contacts of the plant's context, whose positions are `state`."""
        port: Any = self._model.plant.get_contact_results_output_port()
        results = port.Eval(context)
        infos = [
            results.point_pair_contact_info(i) for i in range(results.num_point_pair_contacts())
        ]
        touching = [self._pair(info) for info in infos if info.point_pair().depth > self._depth]
        return touching + self._with_static_objects(state)

    def _with_static_objects(self, state: Array) -> list[TouchingPair]:
        if self._probe is None:
            return []
        rows = self._model.static_objects.rows
        return [
            TouchingPair(pair.bodies, pair.distance, pair.points)
            for pair in self._probe.pairs_within(state, -self._depth)
            if not rows.keys().isdisjoint(pair.bodies)
        ]

    def _pair(self, info: PointPairContactInfo) -> TouchingPair:
        pair = info.point_pair()
        names = self._model.body_names
        sides = [
            (names[info.bodyA_index()], pair.p_WCa),
            (names[info.bodyB_index()], pair.p_WCb),
        ]
        (a, p_wa), (b, p_wb) = sorted(sides, key=lambda side: side[0])
        force = float(np.linalg.norm(info.contact_force()))
        return TouchingPair((a, b), -float(pair.depth), np.array([p_wa, p_wb]), force)
