"""Shown: where an execution failed, as `failure.html` has it of a plan."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.error_runs.asking import Asking
from benchmarks.error_runs.made import Page, Place
from planning import ModelLibrary, World, load_world, parse_scene
from planning.world.replay.still_writer import Still, still_html


@dataclass(frozen=True)
class Shown:
    """What a page shows of the latest revision of a scene.

    Attributes:
        asking: Has the scene.
        scene: Its id.
        title: Of the page.
        notes: Lines below the title.
        at: Measured positions by group.
        ghost: Positions by group that are drawn once more, green and translucent; None for none.
        marked: Full names of the bodies in red.
        camera: Where the camera is, and what it looks at, p_WC and p_WT [m]; None for a good one.
    """

    asking: Asking
    scene: str
    title: str
    notes: Sequence[str]
    at: Mapping[str, Any]
    ghost: Mapping[str, Any] | None = None
    marked: Sequence[str] = ()
    camera: tuple[Place, Place] | None = None

    def page(self) -> Page:
        """Load the scene in this process, and return the page."""
        path = f"/v1/scenes/{self.scene}"
        document = self.asking.done("GET", path)["document"]
        world = load_world(parse_scene(document), ModelLibrary.bundled())
        still = Still(
            title=self.title,
            notes=self.notes,
            state=_state(world, self.at),
            marked=self.marked,
            ghost=None if self.ghost is None else _state(world, self.ghost),
        )
        return Page(still_html(world, still), self.camera)


def _state(world: World, positions: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    """Return the scene's state with some groups elsewhere."""
    state = np.array(world.state)
    for name, values in positions.items():
        state[world.drake.position_indices(world.group(name))] = values
    return state
