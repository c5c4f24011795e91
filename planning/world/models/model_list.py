"""Robots of a library, and a summary of each."""

from planning.domain.geometry.pose import Pose
from planning.domain.scene.scene import Scene, SceneRobot
from planning.domain.scene.summary import RobotSummary
from planning.world.loading.load_world import load_world
from planning.world.models.model_library import ModelLibrary
from planning.world.scene_summary import scene_summary


def list_models(library: ModelLibrary) -> tuple[str, ...]:
    """Return the names of the robots in a library, sorted."""
    return library.names


def describe_model(library: ModelLibrary, name: str) -> RobotSummary:
    """Return the summary of a robot, loaded alone under its own name.

    Raises:
        UnknownName: There is no such robot.
        ModelInvalid: It does not load.
    """
    source = library.find(name)
    robot = SceneRobot(name, name, Pose.identity(), None)
    world = load_world(Scene(name, (robot,)), library)
    summary = scene_summary(world)
    own = world.robot_groups[0]
    card = source.card
    return RobotSummary(
        name=name,
        description=card.description if card else "",
        groups={key: summary.groups[group.name] for key, group in own.groups.items()},
        default_group=own.default,
        bodies=tuple(body for body in summary.bodies if body != "world"),
        sources=tuple((entry.what, entry.from_) for entry in card.sources) if card else (),
        assumed=summary.assumed,
    )
