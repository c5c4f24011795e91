"""simulation_world(): a scene for simulation, whose objects push back, and slip when held."""

from typing import Any

from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    GeometryId,
    HalfSpace,
    ProximityProperties,
    RoleAssign,
)
from pydrake.multibody.plant import CoulombFriction

from planning.domain.robot.joints import JointGroup
from planning.domain.scene.scene import SceneObject
from planning.errors import ModelInvalid
from planning.world.drake_model import DrakeModel
from planning.world.files.stored_scene import store_files
from planning.world.loading.builder import TIME_STEP, build_diagram
from planning.world.world import World

# Pressure of an object at full penetration [Pa]: hard rubber, so that fingers of 100 N sink in by
# less than a millimetre.
_MODULUS = 2e7
# Objects that are fixed to the world and push back: Drake's model grows with their square.
_MAX_OBJECTS = 48
# Edges of the flat pieces that round shapes are cut into [m], and steps of their simulation [s].
_RESOLUTION, _GRIP_TIME_STEP = 0.01, 0.002


def gripped_objects(world: World, group: JointGroup) -> tuple[SceneObject, ...]:
    """Return the objects that a moving group carries, and that are held by contact.

    A gripper that is itself in the group opens or closes as it is told, so what it holds is not
    among them.
    """
    plant = world.drake.plant
    moved = plant.GetBodiesKinematicallyAffectedBy([
        world.drake.joint_indices[joint.name] for joint in group.joints
    ])
    names = {world.drake.body_names.get(body) for body in moved}
    own = {joint.name for joint in group.joints}
    return tuple(
        thing
        for thing in world.scene.objects
        if thing.attached is not None
        and (grip := thing.attached.grip) is not None
        and thing.name in names
        and own.isdisjoint(joint.name for joint in world.group(grip.gripper).joints)
    )


def simulation_world(world: World, held: tuple[SceneObject, ...]) -> World:
    """Return a scene whose objects push back, and in which some of them float in their frames.

    Nothing holds those yet. Contacts between them and bodies that they may touch count, as patches
    of pressure (hydroelastic: Elandt et al., A pressure field model for fast, robust approximation
    of net contact force and moment between nominally rigid objects, IROS 2019): a point of contact
    would not resist turning. In scenes of more than 48 objects that are fixed to the world, these
    exert no force.

    Args:
        world: The scene.
        held: The attached objects that float.

    Raises:
        ModelInvalid: An object has no mass.
    """
    rows = world.drake.static_objects.rows
    static_names = frozenset(rows) if len(rows) > _MAX_OBJECTS else frozenset[str]()
    if not (held or world.drake.half_spaces) and len(static_names) == len(rows):
        return world
    for thing in held:
        if thing.mass is None or isinstance(thing.shape, HalfSpace):
            message = f"object {thing.name!r} is held by contact, so it needs a `mass`"
            raise ModelInvalid(message, {"file": "", "reason": f"{thing.name} has no mass"})
    stored = store_files(world.scene, world.library)
    names = frozenset(thing.name for thing in held)
    with stored.original_names_in_errors():
        model, robots = build_diagram(
            stored,
            static_names,
            loose_names=names,
            is_simulated=True,
            time_step=_GRIP_TIME_STEP if held else TIME_STEP,
            kernel=world.drake.uses_kernel,
        )
        for thing in held:
            _soften(model, thing)
        return World(stored.scene, world.library, model, robots)


def touched_bodies(model: DrakeModel, name: str) -> frozenset[str]:
    """Return the bodies that a held object may touch."""
    return frozenset(
        other
        for pair, (reason, _) in model.unchecked_reasons.items()
        if reason == "held" and name in pair
        for other in pair - {name}
    )


def _soften(model: DrakeModel, thing: SceneObject) -> None:
    """Give an object a field of pressure, and rigid surfaces to what it may touch."""
    attached = thing.attached
    friction = 1.0 if attached is None or attached.grip is None else attached.grip.friction
    soft = ProximityProperties()
    AddContactMaterial(properties=soft, friction=CoulombFriction(friction, friction))
    AddCompliantHydroelasticProperties(_RESOLUTION, _MODULUS, soft)
    _assign(model, thing.name, soft)
    for body in touched_bodies(model, thing.name):
        for geometry in _geometries(model, body):
            found = model.scene_graph.model_inspector().GetProximityProperties(geometry)
            rigid = ProximityProperties(found)
            if not rigid.HasProperty("hydroelastic", "compliance_type"):
                AddRigidHydroelasticProperties(_RESOLUTION, rigid)
                _replace(model, geometry, rigid)
    # Drake caches the model context with its first context; this clears the cache.
    model.scene_graph.set_config(model.scene_graph.get_config())


def _assign(model: DrakeModel, body: str, properties: ProximityProperties) -> None:
    for geometry in _geometries(model, body):
        _replace(model, geometry, properties)


def _replace(model: DrakeModel, geometry: GeometryId, properties: ProximityProperties) -> None:
    source: Any = model.plant.get_source_id()
    model.scene_graph.AssignRole(source, geometry, properties, RoleAssign.kReplace)


def _geometries(model: DrakeModel, body: str) -> list[GeometryId]:
    found = model.plant.get_body(model.bodies[body])
    return list(model.plant.GetCollisionGeometriesForBody(found))
