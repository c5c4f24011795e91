"""NearestMark: the segment between the nearest points of two bodies, with its length."""

from typing import Any

import numpy as np
import viser

from service.studio.motions.nearness import NearestPair
from service.studio.motions.trace import clearance_colors
from service.studio.texts import millimetres, short

_THICKNESS = 0.005
# Farther apart nothing is marked [m].
_FAR = 0.05


class NearestMark:
    """A segment that moves along with a motion; hidden where everything is far."""

    def __init__(self, scene: viser.SceneApi) -> None:
        """Draw nothing yet.

        Args:
            scene: Of one browser.
        """
        self._scene = scene
        self._segment: Any = None
        self._label: Any = None

    def show(self, pair: NearestPair | None) -> None:
        """Draw the segment of a pair; none to hide it."""
        if pair is None or pair.distance > _FAR:
            self.hide()
            return
        text = f"{millimetres(pair.distance)} {'–'.join(map(short, pair.bodies))}"  # noqa: RUF001
        middle = tuple(pair.points.mean(axis=0))
        color = clearance_colors(np.array([pair.distance]))[0].astype(np.uint8)
        self._segment = self._scene.add_line_segments(
            "/nearest/segment", pair.points[None], color, thickness=_THICKNESS
        )
        if self._label is None:
            # Up and to the left: names of frames stand down and to the right of theirs.
            self._label = self._scene.add_label(
                "/nearest/label", text, position=middle, anchor="bottom-right"
            )
        else:
            self._label.text, self._label.position = text, middle

    def hide(self) -> None:
        """Take it away."""
        for node in (self._segment, self._label):
            if node is not None:
                node.remove()
        self._segment = self._label = None
