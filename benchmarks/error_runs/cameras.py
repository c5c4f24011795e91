"""aimed(): has the camera of a page look from one place to another."""

from collections.abc import Callable, Sequence
from typing import Any

# Meshcat's camera has y upwards in its own frame.
_LOOK = """([from, to]) => {
  viewer.handle_command({type: "set_target", value: [to[0], to[2], -to[1]]});
  viewer.handle_command({
    type: "set_property", path: "/Cameras/default/rotated/<object>",
    property: "position", value: [from[0], from[2], -from[1]],
  });
}"""


def aimed(camera: Sequence[Sequence[float]]) -> Callable[[Any], None]:
    """Return what aims the camera of a page.

    Args:
        camera: Where it is and what it looks at, p_WC and p_WT [m].
    """

    def aim(page: Any) -> None:
        page.evaluate(_LOOK, [list(place) for place in camera])

    return aim
