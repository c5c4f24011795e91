"""weld_base(): weld a robot's base to the world, or let it float."""

from collections.abc import Sequence

from pydrake.math import RigidTransform
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody

from planning.errors import SceneInvalid, UnknownName
from planning.world.loading.scene_build import Build, LoadedRobot


def weld_base(build: Build, loaded: LoadedRobot, instances: Sequence[ModelInstanceIndex]) -> None:
    """Weld the base of a robot to the world, or let it float, by its scene and its files.

    A base that floats although the scene does not say so gets a warning.

    Args:
        build: With the robot, which is the last one, before the plant is finalized.
        loaded: The robot.
        instances: The robot's models.

    Raises:
        UnknownName: The card names a base link that does not exist.
        SceneInvalid: The scene contradicts the description.
    """
    robot = loaded.scene_robot
    free = _free_links(build, loaded, instances)
    base = _base_link(build, loaded, free)
    x_wb = RigidTransform(robot.base.matrix)
    is_urdf = loaded.source.card is not None or loaded.file.root_link != ""
    if base is None:
        _validate_unset_base(build, loaded, free)
    elif robot.weld or (robot.weld is None and is_urdf):
        build.plant.WeldFrames(build.plant.world_frame(), base.body_frame(), x_wb)
        free = [link for link in free if link.index() != base.index()]
    else:
        _validate_stated_weld(build, loaded, base)
        build.plant.SetDefaultFloatingBaseBodyPose(base, x_wb)
    if robot.weld is None:
        build.warnings += [
            _floating_warning(robot.name, link.name(), is_base=link is base) for link in free
        ]


def _free_links(
    build: Build, loaded: LoadedRobot, instances: Sequence[ModelInstanceIndex]
) -> list[RigidBody]:
    """Return the root links: those without a parent joint."""
    plant = build.plant
    joined = {joint.child for joint in loaded.file.floating}  # by joints that Drake does not have
    carried = {int(plant.get_joint(i).child_body().index()) for i in plant.GetJointIndices()}
    links = [plant.get_body(i) for one in instances for i in plant.GetBodyIndices(one)]
    return [
        link for link in links if int(link.index()) not in carried and link.name() not in joined
    ]


def _base_link(build: Build, loaded: LoadedRobot, free: list[RigidBody]) -> RigidBody | None:
    """Return the link to weld or float: the card's, the URDF's root, or the only free one."""
    card = loaded.source.card
    name = card.base if card else loaded.file.root_link
    if card and f"{loaded.scene_robot.name}::{name}" not in build.bodies:
        links = [known.partition("::")[2] for known in build.bodies if "::" in known]
        raise UnknownName.among("link", name, links)
    found = [link for link in free if not name or link.name() == name]
    return found[0] if len(found) == 1 else None


def _validate_unset_base(build: Build, loaded: LoadedRobot, free: list[RigidBody]) -> None:
    """Raise if the scene sets what the description determines itself."""
    robot = loaded.scene_robot
    path = f"robots.{len(build.robots) - 1}"
    names = [link.name() for link in free]
    field = f"{path}.weld" if robot.weld is not None else f"{path}.base"
    if robot.weld is None and RigidTransform(robot.base.matrix).IsNearlyIdentity(0.0):
        return
    if len(free) > 1:
        message = f"{field}: {robot.name!r} has {len(free)} root links (links without a parent "
        message += f"joint), {names}, so its base pose cannot be set"
        raise SceneInvalid(message, {"path": field, "links": names})
    message = f"{field}: the description of {robot.name!r} already fixes it to the world: remove "
    message += f"`{field[len(path) + 1 :]}`"
    raise SceneInvalid(message, {"path": field})


def _validate_stated_weld(build: Build, loaded: LoadedRobot, base: RigidBody) -> None:
    """Raise unless the scene declares floating a base for which it gives a pose."""
    robot = loaded.scene_robot
    if robot.weld is None and not RigidTransform(robot.base.matrix).IsNearlyIdentity(0.0):
        path = f"robots.{len(build.robots) - 1}.base"
        message = f"{path}: {base.name()!r}, the base of {robot.name!r}, has no parent joint in "
        message += f"{loaded.file.file.name}, so it floats: set `weld: true` to weld it there, or "
        message += "`weld: false` to let it float from there"
        raise SceneInvalid(message, {"path": path, "link": base.name()})


def _floating_warning(robot: str, link: str, *, is_base: bool) -> str:
    if not is_base:
        return (
            f"{robot}: its link {link!r} has no parent joint and is not its base, so it floats: "
            "add a joint from another link to it"
        )
    return (
        f"{robot}: its base link {link!r} has no parent joint, so it is a floating base: "
        f"`weld: true` of robot {robot!r} welds it to the world, `weld: false` confirms the "
        "floating base"
    )
