"""Cell: the robots and obstacles of the soak, built here by Drake alone, to look for collisions."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydrake.geometry import Box, CollisionFilterDeclaration, GeometrySet
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

_MODELS = Path(__file__).resolve().parents[2] / "models" / "ur5e"
# Where the obstacle is while it is not in the scene [m].
_AWAY = (50.0, 50.0, 50.0)
SIDE = 0.08
TABLE = {"size": [2.4, 1.4, 0.05], "position": [0.4, 0.0, -0.045]}
# Names, and where the bases are: x [m] and yaw [rad].
BASES = (("left", 0.0, 0.0), ("right", 1.1, np.pi))


def document(count: int) -> dict[str, Any]:
    """Return the scene of one or two robots, as it is posted."""
    robots = [
        {
            "name": name,
            "model": "ur5e",
            "positions": "home",
            "base": {"position": [x, 0.0, 0.0], "rpy": [0.0, 0.0, yaw]},
        }
        for name, x, yaw in BASES[:count]
    ]
    table = {"name": "table", "shape": {"box": TABLE["size"]}}
    table["pose"] = {"position": TABLE["position"]}
    allowed = [["table", f"{name}::base_link"] for name, _, _ in BASES[:count]]
    return {"name": "soak", "robots": robots, "objects": [table], "allowed_collisions": allowed}


class Cell:
    """Says where measured motions touch something; it knows nothing of the service."""

    def __init__(self, count: int) -> None:
        """Build one or two robots over a table, and one obstacle that may be anywhere."""
        builder = DiagramBuilder()
        self._plant, self._scene_graph = AddMultibodyPlantSceneGraph(builder, 0.001)
        card = yaml.safe_load((_MODELS / "robot.yaml").read_text(encoding="utf-8"))
        self._robots = [self._add_robot(card, *base) for base in BASES[:count]]
        self._add_box("table", TABLE["size"], TABLE["position"])
        self._late = self._add_box("late", [SIDE] * 3, None)
        self._plant.Finalize()
        self._filter(card, count)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._joints = [
            self._plant.GetJointByName(name, robot).position_start()
            for robot in self._robots
            for name in card["groups"]["arm"]["joints"]
        ]
        gripper = [(robot, name) for robot in self._robots for name in _FINGERS]
        own = self._plant.GetMyContextFromRoot(self._context)
        for robot, name in gripper:
            self._plant.GetJointByName(name, robot).set_translation(own, _OPEN)

    def touching(
        self, rows: Sequence[np.ndarray], obstacles: Sequence[Sequence[float] | None]
    ) -> list[str]:
        """Return what touches what in configurations, each with the obstacle where it was.

        Args:
            rows: Positions of all arms, robot by robot [rad].
            obstacles: Centre of the obstacle at each [m]; None while there was none.
        """
        own = self._plant.GetMyContextFromRoot(self._context)
        q = self._plant.GetPositions(own)
        found: list[str] = []
        for row, place in zip(rows, obstacles, strict=True):
            q[self._joints] = row
            self._plant.SetPositions(own, q)
            pose = RigidTransform(np.array(_AWAY if place is None else place))
            self._plant.SetFreeBodyPose(own, self._late, pose)
            query = self._scene_graph.get_query_output_port().Eval(
                self._scene_graph.GetMyContextFromRoot(self._context)
            )
            inspector = query.inspector()
            for pair in query.ComputePointPairPenetration():
                names = sorted(inspector.GetName(g) for g in (pair.id_A, pair.id_B))
                found.append(f"{' and '.join(names)}: {1e3 * pair.depth:.2f} mm")
            q = self._plant.GetPositions(own)
        return found

    def _add_robot(self, card: dict[str, Any], name: str, x: float, yaw: float) -> Any:
        parser = Parser(self._plant, name)
        (robot,) = parser.AddModels(str(_MODELS / card["file"]))
        base = self._plant.GetFrameByName(card["base"], robot)
        pose = RigidTransform(RollPitchYaw(0.0, 0.0, yaw), np.array([x, 0.0, 0.0]))
        self._plant.WeldFrames(self._plant.world_frame(), base, pose)
        return robot

    def _add_box(self, name: str, size: Sequence[float], place: Sequence[float] | None) -> Any:
        instance = self._plant.AddModelInstance(name)
        inertia = SpatialInertia.SolidBoxWithMass(1.0, *size)
        body = self._plant.AddRigidBody(name, instance, inertia)
        shape, friction = Box(*size), CoulombFriction(1.0, 1.0)
        identity = RigidTransform.Identity()
        self._plant.RegisterCollisionGeometry(body, identity, shape, name, friction)
        if place is not None:
            pose = RigidTransform(np.array(place))
            self._plant.WeldFrames(self._plant.world_frame(), body.body_frame(), pose)
        return body

    def _filter(self, card: dict[str, Any], count: int) -> None:
        manager = self._scene_graph.collision_filter_manager()
        table = self._shapes("table", self._plant.GetModelInstanceByName("table"))
        late = self._shapes("late", self._plant.GetModelInstanceByName("late"))
        pairs = [(table, late)]
        for robot in self._robots[:count]:
            links = card["allowed_collisions"]
            pairs += [(self._shapes(a, robot), self._shapes(b, robot)) for a, b in links]
            pairs.append((table, self._shapes(card["base"], robot)))
        for a, b in pairs:
            manager.Apply(CollisionFilterDeclaration().ExcludeBetween(a, b))

    def _shapes(self, name: str, instance: Any) -> GeometrySet:
        body = self._plant.GetBodyByName(name, instance)
        return GeometrySet(self._plant.GetCollisionGeometriesForBody(body))


_FINGERS, _OPEN = ("left_finger_joint", "right_finger_joint"), 0.025
