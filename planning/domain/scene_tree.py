"""What hangs on what in a scene, as far as the scene itself says it."""

from collections.abc import Mapping
from dataclasses import dataclass

from planning.domain.pose import Pose
from planning.domain.scene import Scene
from planning.domain.value import Value
from planning.errors import SceneInvalid

WORLD = "world"


@dataclass(frozen=True, eq=False)
class Hold(Value):
    """Where something of the scene hangs in the end.

    Attributes:
        root: "world", or a name that the scene does not define: a robot's `robot::link`.
        pose: X_RN, the thing in the root.
    """

    root: str
    pose: Pose

    @property
    def robot(self) -> str | None:
        """The robot whose link the root is, or None."""
        robot, has_robot, _ = self.root.partition("::")
        return robot if has_robot else None


def parents(scene: Scene) -> dict[str, tuple[str, Pose]]:
    """Return the parent P of every object and frame N, and X_PN."""
    objects = {
        thing.name: (thing.attached.frame if thing.attached else WORLD, thing.pose)
        for thing in scene.objects
    }
    return {**objects, **{frame.name: (frame.parent, frame.pose) for frame in scene.frames}}


def hold_of(name: str, above: Mapping[str, tuple[str, Pose]]) -> Hold:
    """Follow `parents` up from an object, a frame or a link.

    Raises:
        SceneInvalid: It hangs on itself.
    """
    seen: list[str] = []
    pose = Pose.identity()
    while name in above:
        if name in seen:
            message = f"{seen[0]!r} hangs on itself: {[*seen, name]}"
            raise SceneInvalid(message, {"path": "", "names": [*seen, name]})
        seen.append(name)
        name, step = above[name]
        pose = step @ pose
    return Hold(name, pose)
