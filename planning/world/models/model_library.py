"""ModelLibrary: folders of robots, searched by name or path."""

import sysconfig
from dataclasses import dataclass
from pathlib import Path

from planning.errors import AssetNotFound, UnknownName
from planning.world.models.robot_card import RobotCard, read_robot_card

_CARD = "robot.yaml"
_SUFFIXES = (".urdf", ".sdf", ".xml")


@dataclass(frozen=True)
class RobotSource:
    """Files of a robot.

    Attributes:
        name: Name of the robot in the request.
        file: Its description.
        card: Its robot.yaml, if there is one beside the description.
        card_file: Path of that file.
    """

    name: str
    file: Path
    card: RobotCard | None
    card_file: Path | None


@dataclass(frozen=True)
class ModelLibrary:
    """Folders of robots, and whether any other file may be loaded as well.

    Attributes:
        roots: Folders of `<robot>/robot.yaml`.
        allow_paths: Whether robots and meshes may be named by the path of any file.
        copies: Folder of the copies that loaded scenes keep of their files; None for one among
            the user's caches.
    """

    roots: tuple[Path, ...]
    allow_paths: bool = True
    copies: Path | None = None

    @classmethod
    def bundled(
        cls, *more: Path, allow_paths: bool = True, copies: Path | None = None
    ) -> "ModelLibrary":
        """Return the library of the robots that come with Wayproof, and of more folders."""
        return cls((*more, bundled_folder("models")), allow_paths, copies)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the robots, sorted."""
        cards = (card for root in self.roots for card in root.glob(f"*/{_CARD}"))
        return tuple(sorted({card.parent.name for card in cards}))

    def find(self, model: str) -> RobotSource:
        """Return the files of a robot.

        Raises:
            UnknownName: There is no robot of that name.
            AssetNotFound: There is no file at that path, or paths are not allowed.
        """
        for root in self.roots:
            card_file = root / model / _CARD
            if model in self.names and card_file.is_file():
                card = read_robot_card(card_file)
                return RobotSource(model, card_file.parent / card.file, card, card_file)
        if "/" not in model and not model.lower().endswith(_SUFFIXES):
            raise UnknownName.among("robot", model, self.names)
        return self._find_path(model)

    def _find_path(self, model: str) -> RobotSource:
        path = Path(model)
        if not self.allow_paths:
            message = f"this library loads robots by name only, not {model!r}: {list(self.names)}"
            raise AssetNotFound(message, {"uri": model, "known": list(self.names)})
        if path.suffix.lower() not in _SUFFIXES:
            message = f"{model!r} is not a robot description; supported endings: {list(_SUFFIXES)}"
            if path.suffix.lower() == ".xacro":
                message += f"; expand it first: {expansion(path.name)}"
            raise AssetNotFound(message, {"uri": model, "known": list(_SUFFIXES)})
        if not path.is_file():
            message = f"there is no file {model!r}"
            raise AssetNotFound(message, {"uri": model, "known": list(self.names)})
        path = path.resolve()
        card_file = path.parent / _CARD
        card = read_robot_card(card_file) if card_file.is_file() else None
        if card is None or card.file != path.name:
            return RobotSource(model, path, None, None)
        return RobotSource(model, path, card, card_file)


def expansion(xacro: str) -> str:
    """Return the command that converts a xacro file to URDF."""
    stem = xacro.partition(".")[0]
    return f"`xacro {xacro} > {stem}{'-expanded' if xacro.endswith('.urdf') else ''}.urdf`"


def bundled_folder(name: str) -> Path:
    """Return the folder `models` or `scenes` of this checkout or of the installed package."""
    beside_the_code = Path(__file__).resolve().parents[3] / name
    if beside_the_code.is_dir():
        return beside_the_code
    return Path(sysconfig.get_path("data")) / "share" / "wayproof" / name
