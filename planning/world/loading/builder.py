"""Builder of a scene's Drake diagram: robots, objects, frames and filters."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    ModelInstanceIndex,
    QuaternionFloatingJoint,
    SpatialInertia,
)
from pydrake.planning import RobotDiagramBuilder

from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import HalfSpace, Mesh
from planning.domain.scene.scene import Scene, SceneObject, SceneRobot
from planning.errors import ModelInvalid, SceneInvalid
from planning.world.drake_model import DrakeModel
from planning.world.files.mesh_check import validate_mesh
from planning.world.files.stored_meshes import validate_stored_meshes
from planning.world.files.stored_scene import StoredScene
from planning.world.loading.attached_objects import validate_owners
from planning.world.loading.collision_filters import (
    allow_attached_contacts,
    allow_collisions,
    exclude_adjacent_links,
)
from planning.world.loading.drake_shapes import drake_shape
from planning.world.loading.frame_build import add_frames
from planning.world.loading.inspected_copies import inspect_copy
from planning.world.loading.mass import spatial_inertia
from planning.world.loading.scene_build import Build, LoadedRobot, validate_unused_name
from planning.world.loading.static_build import make_static_objects
from planning.world.models.base_weld import weld_base
from planning.world.models.collision_count import collision_counts, validate_num_shapes
from planning.world.models.couplings import couplings, joint_indices
from planning.world.models.model_file import FloatingJoint
from planning.world.models.model_warnings import parser_warnings, visual_only_warnings

# Steps of the plant [s]; they matter only to simulation.
TIME_STEP = 0.001
# Pushes back in place of a half space, with its origin on it [m].
_SLAB = Box(1000.0, 1000.0, 10.0), RigidTransform(np.array([0.0, 0.0, -5.0]))
DEFAULT_COLOR = np.array([0.72, 0.62, 0.48, 1.0])


def build_diagram(
    stored: StoredScene,
    static_names: frozenset[str] = frozenset(),
    *,
    loose_names: frozenset[str] = frozenset(),
    is_simulated: bool = False,
    time_step: float = TIME_STEP,
    kernel: bool = True,
) -> tuple[DrakeModel, tuple[LoadedRobot, ...]]:
    """Return the scene's Drake model, and its loaded robots.

    Args:
        stored: The scene, with its files.
        static_names: Names of the objects that are kept outside of Drake's model.
        loose_names: Names of attached objects that float in their frames, and whose contacts with
            the bodies that they may touch count: for simulation.
        is_simulated: Whether half spaces have to push back.
        time_step: Of the plant [s]; matters only to simulation.
        kernel: Whether the native kernel may decide collisions where it is certain.

    Raises:
        SceneInvalid: A name is given twice, or a frame is its own ancestor.
        AssetNotFound: A file does not exist.
        ModelInvalid: A robot does not load.
        UnknownName: A parent frame or body does not exist.
    """
    scene = stored.scene
    builder: Any = RobotDiagramBuilder(time_step=time_step)
    build = Build(builder, builder.plant(), static_names, loose_names, is_simulated=is_simulated)
    build.frames["world"] = build.plant.world_frame()
    build.bodies["world"] = build.plant.world_body().index()
    for i, robot in enumerate(scene.robots):
        validate_unused_name(build, robot.name, f"robots.{i}.name")
        _add_robot(build, robot, stored)
    for i, thing in enumerate(scene.objects):
        validate_unused_name(build, thing.name, f"objects.{i}.name")
        if thing.name in static_names:
            build.static_names_added.add(thing.name)
        else:
            _add_object(build, stored.stored_object(thing), f"objects.{i}.shape")
    static_objects = make_static_objects(stored, static_names)
    add_frames(build, scene.frames, static_objects.frames)
    owners = _attach(build, scene, static_objects.frames)
    # Adjacent links are excluded by evidence, not all of them (`exclude_adjacent_links`).
    build.plant.set_adjacent_bodies_collision_filters(False)
    build.plant.Finalize()
    allow_collisions(build, scene)
    allow_attached_contacts(build, scene)
    scene_graph = builder.scene_graph()
    indices = joint_indices(build.plant, build.bodies)
    diagram = builder.Build()
    exclude_adjacent_links(build, scene, diagram, scene_graph)
    names = {index: name for name, index in build.bodies.items()}
    model = DrakeModel(
        diagram=diagram,
        plant=build.plant,
        scene_graph=scene_graph,
        body_names=names,
        bodies=build.bodies,
        frames=build.frames,
        joint_indices=indices,
        couplings=couplings(
            build.plant,
            indices,
            [(robot.scene_robot.name, m) for robot in build.robots for m in robot.file.mimics],
        ),
        owners=owners,
        static_objects=static_objects,
        half_spaces=build.half_spaces,
        uses_kernel=kernel,
        unchecked_reasons=build.unchecked,
        warnings=tuple(dict.fromkeys(build.warnings)),
    )
    return model, tuple(build.robots)


def build_single(thing: SceneRobot | SceneObject, stored: StoredScene) -> None:
    """Build a single robot or object; raises as `build_diagram`."""
    builder: Any = RobotDiagramBuilder(time_step=TIME_STEP)
    build = Build(builder, builder.plant())
    if isinstance(thing, SceneRobot):
        _add_robot(build, replace(thing, base=Pose.identity()), stored)
    else:
        _add_object(build, replace(stored.stored_object(thing), attached=None), thing.name)
    build.plant.Finalize()


def _add_robot(build: Build, robot: SceneRobot, stored: StoredScene) -> None:
    source = stored.source(robot.name)
    file = build.files.get(source.file) or inspect_copy(source.file, stored.store.meshes)
    build.files[source.file] = file
    parser = build.builder.parser()
    parser.SetAutoRenaming(value=True)
    packages = parser.package_map()
    for package in packages.GetPackageNames():  # Drake's own, and those of the robot before
        packages.Remove(package)
    for package, folder in file.packages.items():
        packages.Add(package, str(folder))
    before = collision_counts(build.plant, [build.plant.world_body().index()])
    try:
        with parser_warnings(robot.name, build.warnings):
            instances = (
                parser.AddModels(str(source.file))
                if file.rewritten is None
                else parser.AddModelsFromString(file.rewritten, _format_of(source.file))
            )
    except (RuntimeError, ValueError, SystemExit) as fault:  # SystemExit at invalid sizes
        message = f"robot {robot.name!r}: {source.file.name} does not load: {fault}"
        raise ModelInvalid(message, {"file": str(source.file), "reason": str(fault)}) from fault
    if not instances:
        message = f"robot {robot.name!r}: {source.file.name} describes no model"
        raise ModelInvalid(message, {"file": str(source.file), "reason": "no model"})
    _add_bodies(build, robot, instances, source.file)
    validate_num_shapes(build.plant, instances, file.shapes, before, source.file)
    build.warnings += visual_only_warnings(
        build.builder.scene_graph(), build.plant, instances, robot.name
    )
    loaded = LoadedRobot(robot, source, file, instances[0])
    build.robots.append(loaded)
    validate_stored_meshes(
        build, instances, source.file, (stored.folder(robot.name), stored.store.meshes)
    )
    weld_base(build, loaded, instances)
    build.warnings += [_unlimited_warning(robot.name, joint) for joint in file.unlimited]
    for joint in file.floating:
        _add_floating(build, robot.name, joint)


def _unlimited_warning(robot: str, joint: str) -> str:
    return (
        f"{robot}::{joint} has no `limit` with `lower` and `upper` and is treated as unlimited: "
        "add the limits, or make it `continuous`"
    )


def _add_bodies(
    build: Build, robot: SceneRobot, instances: Sequence[ModelInstanceIndex], file: Path
) -> None:
    for index in (i for instance in instances for i in build.plant.GetBodyIndices(instance)):
        body = build.plant.get_body(index)
        full = f"{robot.name}::{body.name()}"
        if full in build.bodies:
            reason = f"two links, of models inside each other, have the name {body.name()!r}"
            message = f"robot {robot.name!r}: {file.name}: {reason}"
            raise ModelInvalid(message, {"file": str(file), "reason": reason})
        build.bodies[full] = index
        build.frames[full] = body.body_frame()


def _add_floating(build: Build, robot: str, joint: FloatingJoint) -> None:
    frame_p, frame_c = (build.frames[f"{robot}::{link}"] for link in (joint.parent, joint.child))
    x_pf = RigidTransform(RollPitchYaw(np.array(joint.rpy)), np.array(joint.xyz))
    if not x_pf.IsExactlyIdentity():
        frame_p = build.plant.AddFrame(FixedOffsetFrame(f"{robot}::{joint.name}", frame_p, x_pf))
    build.plant.AddJoint(QuaternionFloatingJoint(joint.name, frame_p, frame_c))


def _format_of(file: Path) -> str:
    """Return Drake's name of the file format with this ending."""
    return {".urdf": "urdf", ".sdf": "sdf", ".xml": "xml"}[file.suffix.lower()]


def _add_object(build: Build, thing: SceneObject, path: str) -> None:
    if isinstance(thing.shape, Mesh):
        validate_mesh(Path(thing.shape.uri), f"{path}: object {thing.name!r}")
    try:
        shape, x_og = drake_shape(thing.shape), RigidTransform()
        instance = build.plant.AddModelInstance(thing.name)
        # Objects that are fixed to the world load no joint, so they need no mass.
        inertia = spatial_inertia(thing) if thing.attached else SpatialInertia.NaN()
        body = build.plant.AddRigidBody(thing.name, instance, inertia)
        color = DEFAULT_COLOR if thing.color is None else thing.color
        visual = build.plant.RegisterVisualGeometry(body, x_og, shape, thing.name, color)
        if isinstance(thing.shape, HalfSpace) and thing.attached is None:
            # Drake's broadphase ends the process where one is among a few dozen shapes.
            build.half_spaces[visual] = thing.name
            shape, x_og = _SLAB if build.is_simulated else (None, x_og)
        if shape is not None:
            build.plant.RegisterCollisionGeometry(
                body, x_og, shape, thing.name, CoulombFriction(0.9, 0.8)
            )
    except (RuntimeError, ValueError, SystemExit) as fault:
        message = f"{path}: object {thing.name!r} does not load: {fault}"
        raise SceneInvalid(message, {"path": path}) from fault
    if thing.attached is None:
        x_wo = RigidTransform(thing.pose.matrix)
        build.plant.WeldFrames(build.plant.world_frame(), body.body_frame(), x_wo)
    build.bodies[thing.name] = body.index()
    build.frames[thing.name] = body.body_frame()


def _attach(
    build: Build, scene: Scene, static_frames: Mapping[str, RigidTransform]
) -> dict[str, str]:
    """Weld every attached object to its frame, or let it float in it; return the robot of each."""
    owners = validate_owners(scene, {*build.frames, *static_frames})
    for thing in scene.objects:
        if thing.attached is not None:
            frame, body = build.frames[thing.attached.frame], build.frames[thing.name]
            x_fo = RigidTransform(thing.pose.matrix)
            if thing.name in build.loose_names:
                joint = build.plant.AddJoint(QuaternionFloatingJoint(thing.name, frame, body))
                joint.SetDefaultPose(x_fo)
            else:
                build.plant.WeldFrames(frame, body, x_fo)
    return owners


def pose_of(transform: RigidTransform) -> Pose:
    """Return a Drake transform as a domain pose."""
    return Pose.from_matrix(transform.GetAsMatrix4())
