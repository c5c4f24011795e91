"""ModelFile: inspection of a robot description before Drake parses it, and data that Drake ignores.

Drake's parser ends the process (SystemExit) at a box of size zero, downloads some packages, and
accepts negative masses: such descriptions are refused here. It ignores URDF's `floating` joints,
`mimic`, and MJCF's equalities of joints: these are returned.
"""

import os
import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from planning.errors import AssetNotFound
from planning.world.documents.xml_file import xml_root
from planning.world.files.mesh_check import validate_mesh
from planning.world.files.mesh_files import with_readable_meshes
from planning.world.files.sdf_includes import included_models
from planning.world.models.collision_count import StatedShape, stated_shapes
from planning.world.models.missing_limits import unlimited_joints
from planning.world.models.mjcf_file import (
    joint_equalities,
    validate_supported_elements,
    with_includes,
)
from planning.world.models.model_faults import (
    invalid,
    number_in,
    validate_description,
    validate_name,
)

# Largest dry friction [N m or N].
_MAX_FRICTION = 1e6
PACKAGE = re.compile(r"^(?:package|model)://([^/]+)/(.*)$")


@dataclass(frozen=True)
class Mimic:
    """Mimic joint: q = multiplier * q_leader + offset."""

    follower: str
    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class FloatingJoint:
    """URDF joint of type floating.

    Attributes:
        name: Of the joint.
        parent: Its parent link P.
        child: Its child link, at the joint's frame F where all coordinates are zero.
        xyz: Origin of F in P [m], shape (3,).
        rpy: Roll, pitch and yaw of F in P [rad], shape (3,).
    """

    name: str
    parent: str
    child: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]


@dataclass(frozen=True)
class ModelFile:
    """Data of a description in addition to what Drake reads.

    Attributes:
        file: The description.
        root_link: The link without a parent joint, or "" where the format hides it.
        floating: Every URDF joint of type floating.
        mimics: Joints that follow others.
        effort: Largest effort by joint, where the file states it [N m or N].
        friction: Dry friction by joint, where a URDF states it, which Drake ignores [N m or N].
        packages: Folder of every package that the file names.
        rewritten: The description with converted meshes; None if Drake reads the original ones.
        disabled_pairs: Pairs of links that an SRDF of the same name allows to touch.
        shapes: Collision shapes in the description.
        unlimited: Joints without position limits, though their type has limits.
    """

    file: Path
    root_link: str
    floating: tuple[FloatingJoint, ...]
    mimics: tuple[Mimic, ...]
    effort: dict[str, float]
    friction: dict[str, float]
    packages: dict[str, Path]
    rewritten: str | None
    disabled_pairs: tuple[tuple[str, str], ...]
    shapes: tuple[StatedShape, ...]
    unlimited: tuple[str, ...]


def inspect_model(file: Path, converted_meshes: Path) -> ModelFile:
    """Return the data of a description, if it is safe to give to Drake.

    Args:
        file: The description.
        converted_meshes: Folder of meshes converted from those that Drake does not read.

    Raises:
        AssetNotFound: A package, mesh or included MJCF file that it names does not exist.
        ModelInvalid: It is not XML, too large, has a document type, includes itself, or has a
            fault that Drake does not handle (`validate_description`); or it is MJCF with parts that
            Drake ignores.
    """
    root = _parse(file)
    is_mjcf = root.tag == "mujoco"
    includes = is_mjcf and with_includes(file, root)
    if is_mjcf:
        validate_supported_elements(file, root)
    validate_description(file, root)
    packages, meshes = _find_meshes(file, root)
    models = [root, *included_models(file, root, packages)]
    for model in models[1:]:
        validate_description(file, model)
    is_nameless = is_mjcf and not root.get("model")
    if is_nameless:  # MuJoCo needs no name, Drake does
        root.set("model", file.stem)
    links = [link.get("name", "") for link in root.iter("link")]
    children = {child.get("link", "") for child in root.iter("child")}
    roots = [name for name in links if name not in children] if root.tag == "robot" else []
    return ModelFile(
        file=file,
        root_link=roots[0] if roots else "",
        floating=tuple(
            _floating(file, joint)
            for joint in root.iter("joint")
            if joint.get("type") == "floating" and root.tag == "robot"
        ),
        mimics=tuple(_equalities(file, root) if is_mjcf else _mimics(file, models)),
        effort=_efforts(root),
        friction=_frictions(file, root),
        packages=packages,
        rewritten=with_readable_meshes(
            file, root, meshes, converted_meshes, always=is_nameless or includes
        ),
        disabled_pairs=tuple(_disabled_pairs(file)),
        shapes=tuple(shape for model in models for shape in stated_shapes(model)),
        unlimited=unlimited_joints(models),
    )


def parse_xml_or_none(content: bytes) -> ET.Element | None:
    """Return the root of an XML text that is safe to parse; None for any other."""
    try:
        return xml_root(content)
    except ValueError:
        return None


def _parse(file: Path) -> ET.Element:
    try:
        return xml_root(file.read_bytes())
    except ValueError as fault:
        raise invalid(file, str(fault)) from fault


def _find_meshes(file: Path, root: ET.Element) -> tuple[dict[str, Path], dict[str, Path]]:
    """Return the folder of each package, and the path of each mesh by its name in the file."""
    packages: dict[str, Path] = {}
    meshes: dict[str, Path] = {}
    stated = [compiler.get("meshdir") for compiler in root.findall("compiler")]
    mesh_folder = file.parent / ([folder for folder in stated if folder] or [""])[-1]
    for element in root.iter():
        child = element.find("uri")
        uri = element.get("filename") or element.get("file")
        uri = (uri or (child.text if child is not None else None) or "").strip()
        if element.tag.rsplit("}", 1)[-1] != "mesh" or not uri:
            continue
        match = PACKAGE.match(uri)
        if match:
            packages.setdefault(match[1], package_folder(file, match[1], uri))
            meshes[uri] = packages[match[1]] / match[2]
        elif "://" in uri:
            message = f"{file.name} names {uri!r}; only files and package:// are supported"
            raise AssetNotFound(message, {"uri": uri, "known": ["package://", "relative path"]})
        else:
            meshes[uri] = (mesh_folder if root.tag == "mujoco" else file.parent) / uri
        meshes[uri] = Path(os.path.normpath(meshes[uri]))  # as Drake does
        if not meshes[uri].is_file():
            place = os.path.relpath(meshes[uri], file.parent)
            message = f"{file.name} names the mesh {uri!r}, but {place!r} does not exist beside it"
            raise AssetNotFound(message, {"uri": uri, "known": sorted(packages)})
        validate_mesh(meshes[uri], file.name)
    return packages, meshes


def package_folder(file: Path, name: str, uri: str) -> Path:
    """Return a package among the folders above the file, by package.xml or the folder's name.

    Raises:
        AssetNotFound: None of them is the package.
    """
    for folder in file.parents:
        manifest = folder / "package.xml"
        if folder.name == name:
            return folder
        if manifest.is_file() and f"<name>{name}</name>" in manifest.read_text("utf-8", "replace"):
            return folder
        if (folder / name).is_dir():
            return folder / name
    message = f"{file.name} names {uri!r}, but no folder above it is the package {name!r}"
    raise AssetNotFound(message, {"uri": uri, "known": [p.name for p in file.parents[:3]]})


def _equalities(file: Path, root: ET.Element) -> list[Mimic]:
    return [
        Mimic(equality.follower, equality.leader, equality.multiplier, equality.offset)
        for equality in joint_equalities(file, root)
    ]


def _mimics(file: Path, models: list[ET.Element]) -> list[Mimic]:
    """Read URDF's and SDF's; in SDF, q = multiplier (q_leader - reference) + offset."""
    found: list[Mimic] = []
    for joint in (joint for model in models for joint in model.iter("joint")):
        mimic = next(joint.iter("mimic"), None)
        if mimic is None:
            continue
        offset = mimic.get("offset") or mimic.findtext("offset") or "0"
        word = mimic.get("multiplier") or mimic.findtext("multiplier") or "1"
        multiplier = number_in(file, "mimic", word)
        reference = number_in(file, "mimic", mimic.findtext("reference") or "0")
        found.append(
            Mimic(
                joint.get("name", ""),
                mimic.get("joint", ""),
                multiplier,
                number_in(file, "mimic", offset) - multiplier * reference,
            )
        )
    return found


def _floating(file: Path, joint: ET.Element) -> FloatingJoint:
    """Read a joint with its `origin`."""
    origin = joint.find("origin")
    xyz, rpy = (
        tuple(number_in(file, "origin", word) for word in words.split())
        for words in (
            "0 0 0" if origin is None else origin.get(name, "0 0 0") for name in ("xyz", "rpy")
        )
    )
    if len(xyz) != 3 or len(rpy) != 3:
        raise invalid(
            file, f"the origin of joint {joint.get('name')!r} must have three numbers each"
        )
    return FloatingJoint(
        joint.get("name", ""), _link(joint, "parent"), _link(joint, "child"), xyz, rpy
    )


def _efforts(root: ET.Element) -> dict[str, float]:
    efforts: dict[str, float] = {}
    for joint in root.iter("joint"):
        limit = joint.find("limit")
        word = limit.get("effort") if limit is not None else None
        if word is not None:
            efforts[joint.get("name", "")] = float(word)  # checked by `validate_description`
    return efforts


def _frictions(file: Path, root: ET.Element) -> dict[str, float]:
    frictions: dict[str, float] = {}
    for joint in root.iter("joint"):
        dynamics = joint.find("dynamics")
        word = dynamics.get("friction") if dynamics is not None else None
        if word is None:
            continue
        name = joint.get("name", "")
        friction = number_in(file, f"joint {name!r}: friction", word)
        if friction < 0:
            raise invalid(file, f"joint {name!r}: friction {word} must not be negative")
        if friction > _MAX_FRICTION:
            raise invalid(
                file, f"joint {name!r}: friction {word} must be at most {_MAX_FRICTION:g}"
            )
        if friction > 0:
            frictions[name] = friction
    return frictions


def _disabled_pairs(file: Path) -> list[tuple[str, str]]:
    """Read the SRDF beside a URDF, if there is one (MoveIt's `disable_collisions`)."""
    srdf = file.with_suffix(".srdf")
    if file.suffix.lower() != ".urdf" or not srdf.is_file():
        return []
    root = _parse(srdf)
    for group in root.findall("group"):
        validate_name(srdf, group)
    pairs = root.iter("disable_collisions")
    return [(pair.get("link1", ""), pair.get("link2", "")) for pair in pairs]


def _link(joint: ET.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")
