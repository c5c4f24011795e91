"""set_stage(): what a scene stands on and is lit by: sky, sun, shadows, a grid into the haze."""

import numpy as np
import viser

# From the top of the page to its bottom, red, green, blue; the haze is what the horizon has.
_SKY = np.array([[206, 220, 236], [236, 242, 248], [250, 251, 253], [250, 251, 253]])
_HAZE = (246, 249, 252)
_SKY_ROWS = 256
# Where the haze begins, and where nothing is seen any more [m].
_NEAR, _FAR = 4.0, 14.0
# A little below the floor, that both are never in one place.
_GRID_HEIGHT = -0.06


def set_stage(scene: viser.SceneApi) -> None:
    """Light a scene from above, with shadows, on a grid that fades away."""
    scene.set_up_direction("+z")
    scene.configure_default_lights(enabled=False)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 150, 160), intensity=2.2
    )
    scene.add_light_directional(
        "/light/sun",
        color=(255, 250, 240),
        intensity=2.4,
        cast_shadow=True,
        position=(2.0, -1.6, 4.0),
    )
    scene.add_grid(
        "/grid",
        width=40.0,
        height=40.0,
        cell_size=0.25,
        section_size=1.0,
        cell_color=(226, 231, 237),
        section_color=(200, 208, 218),
        position=(0.0, 0.0, _GRID_HEIGHT),
        shadow_opacity=0.15,
    )
    scene.set_background_image(_sky(), format="png")
    scene.configure_fog(_NEAR, _FAR, color=_HAZE)


def _sky() -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Return the sky as a picture, shape (rows, 2, 3)."""
    rows, knots = np.linspace(0.0, 1.0, _SKY_ROWS), np.linspace(0.0, 1.0, len(_SKY))
    column = np.stack([np.interp(rows, knots, _SKY[:, i]) for i in range(3)], axis=1)
    return np.repeat(column[:, None], 2, axis=1).round().astype(np.uint8)
