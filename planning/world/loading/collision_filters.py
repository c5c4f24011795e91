"""Collision filters: pairs of bodies that may touch and that Drake does not check."""

from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet, SceneGraph
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram

from planning.domain.scene.scene import Scene
from planning.errors import SceneInvalid, UnknownName
from planning.world.loading.adjacent_links import unchecked_neighbours
from planning.world.loading.attached_objects import allowed_contact_bodies
from planning.world.loading.scene_build import Build, LoadedRobot
from planning.world.models.srdf.srdf_file import end_effector_joints


def allow_collisions(build: Build, scene: Scene) -> None:
    """Filter the pairs that the scene or a robot's own description allows; record the source.

    Raises:
        SceneInvalid: The scene names a body that does not exist.
    """
    source = "the scene's allowed_collisions"
    pairs = [
        (f"allowed_collisions.{i}", pair, source) for i, pair in enumerate(scene.allowed_collisions)
    ]
    for robot in build.robots:
        prefix = robot.scene_robot.name
        card = robot.source.card
        own = [(a, b) for a, b in card.allowed_collisions] if card else robot.file.disabled_pairs
        source = "robot.yaml" if card else "the SRDF beside the description"
        pairs += [("", (f"{prefix}::{a}", f"{prefix}::{b}"), source) for a, b in own]
    known = build.known_bodies
    for path, pair, source in pairs:
        unknown = [name for name in pair if name not in known]
        if unknown and path:
            fault = UnknownName.among("body", unknown[0], known)
            raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
        if unknown and source == "robot.yaml":
            raise UnknownName.among("body", unknown[0], known)
        if not unknown:
            _exclude(build, pair)
            build.unchecked[frozenset(pair)] = ("allowed", f"{source} lets them touch")


def allow_attached_contacts(build: Build, scene: Scene) -> None:
    """Filter the permitted contacts of attached objects, by their own list or by default.

    Raises:
        SceneInvalid: A list names a body that does not exist.
    """
    names = {index: name for name, index in build.bodies.items()}
    known = build.known_bodies
    is_any_attached = any(thing.attached is not None for thing in scene.objects)
    arm_joints = [
        name for robot in build.robots if is_any_attached for name in _arm_joints(build, robot)
    ]
    for i, thing in enumerate(scene.objects):
        if thing.attached is None:
            continue
        touch = thing.attached.touch
        if touch is None:
            found = allowed_contact_bodies(
                build.plant, build.frames[thing.attached.frame], arm_joints
            )
            touch = tuple(names[index] for index in found if index in names)
        for k, name in enumerate(touch):
            if name not in known:
                fault = UnknownName.among("body", name, known)
                path = f"objects.{i}.attached.touch.{k}"
                raise SceneInvalid(f"{path}: {fault.detail}", {"path": path, **fault.evidence})
            if name != thing.name:
                if thing.name not in build.loose_names:
                    _exclude(build, (name, thing.name))
                evidence = f"{thing.name} is attached to {thing.attached.frame} and may touch it"
                build.unchecked[frozenset((name, thing.name))] = ("held", evidence)


def _arm_joints(build: Build, robot: LoadedRobot) -> list[str]:
    """Return the joints of a robot's arm, beyond which no body may be touched by default.

    Without a `robot.yaml` it is every joint but those of the end effectors that an SRDF names: a
    description does not say which links are fingers.
    """
    card = robot.source.card
    if card is not None:
        return list(card.groups[card.default_group].joints)
    prefix = f"{robot.scene_robot.name}::"
    own = {int(index) for name, index in build.bodies.items() if name.startswith(prefix)}
    joints = map(build.plant.get_joint, build.plant.GetJointIndices())
    names = [joint.name() for joint in joints if int(joint.child_body().index()) in own]
    effector_joints = end_effector_joints(robot.file.file)
    return [name for name in names if name not in effector_joints]


def exclude_adjacent_links(
    build: Build, scene: Scene, diagram: RobotDiagram, scene_graph: SceneGraph
) -> None:
    """Filter adjacent links that need no check; contexts made later have the filter.

    A pair with a margin of its own in the scene is always checked.
    """
    filters = scene_graph.collision_filter_manager()
    names = {index: name for name, index in build.bodies.items()}
    pairs_with_margin = {frozenset(entry.bodies) for entry in scene.margins}
    for neighbours in unchecked_neighbours(diagram, build.plant, scene_graph):
        sets = [_geometries(build, index) for index in neighbours.bodies]
        pair = frozenset(names[index] for index in neighbours.bodies)
        if pair in pairs_with_margin:
            continue
        filters.Apply(CollisionFilterDeclaration().ExcludeBetween(*sets))
        build.unchecked[pair] = ("adjacent", neighbours.evidence)
    # Drake caches the model context with its first context; this clears the cache.
    scene_graph.set_config(scene_graph.get_config())


def _exclude(build: Build, pair: tuple[str, str]) -> None:
    if not build.static_names.isdisjoint(pair):
        return  # no pair of Drake's: `static_build` has it
    sets = [_geometries(build, build.bodies[name]) for name in pair]
    filters = build.builder.scene_graph().collision_filter_manager()
    filters.Apply(CollisionFilterDeclaration().ExcludeBetween(*sets))


def _geometries(build: Build, body: BodyIndex) -> GeometrySet:
    ids: list[GeometryId] = list(
        build.plant.GetCollisionGeometriesForBody(build.plant.get_body(body))
    )
    return GeometrySet(ids)
