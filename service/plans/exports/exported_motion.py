"""ExportedMotion: what is written into a file of another program."""

from dataclasses import dataclass

from planning.domain.scene.geometry import SceneMotion
from service.plans.models.trajectory import Trajectory


@dataclass(frozen=True)
class ExportedMotion:
    """A motion as samples, and its scene for formats that show it.

    Attributes:
        samples: The motion.
        scene: Its scene at these samples; None for formats without one.
    """

    samples: Trajectory
    scene: SceneMotion | None = None
