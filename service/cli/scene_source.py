"""Where the scenes that a command names are: bundled ones by name, others by path."""

from pathlib import Path

from planning import bundled_folder
from planning.errors import UnknownName

_SUFFIX = ".scene.yaml"


class NoSuchScene(Exception):
    """There is no scene of that name and no such file."""


def bundled_scenes() -> tuple[str, ...]:
    """Return the names of the scenes that come with Wayproof, sorted."""
    folder = bundled_folder("scenes")
    return tuple(sorted(path.name.removesuffix(_SUFFIX) for path in folder.glob(f"*{_SUFFIX}")))


def read_scene_text(scene: str) -> tuple[bytes, str]:
    """Return the text of a scene and its media type.

    Args:
        scene: A bundled name, or the path of a YAML or JSON file.

    Raises:
        NoSuchScene: There is neither.
    """
    path = Path(scene)
    if scene in bundled_scenes():
        path = bundled_folder("scenes") / f"{scene}{_SUFFIX}"
    try:
        text = path.read_bytes()
    except OSError as fault:
        known, near = bundled_scenes(), UnknownName.among("scene", scene, bundled_scenes())
        hint = "".join(f"did you mean {name!r}? " for name in near.evidence["nearest"][:1])
        message = f"there is no scene {scene!r} and no such file; {hint}bundled scenes: "
        message += ", ".join(known)
        raise NoSuchScene(message) from fault
    is_json = path.suffix.lower() == ".json"
    return text, "application/json" if is_json else "application/yaml"
