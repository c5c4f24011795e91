"""Count of collision shapes: those in a description against those in Drake's plant."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from pydrake.multibody.tree import BodyIndex, ModelInstanceIndex

from planning.errors import ModelInvalid
from planning.world.models.mjcf_file import MjcfDefaults

# Kinds that Drake reads in all formats: where a shape is missing, it is one of the others if any.
_SUPPORTED_KINDS = {"box", "capsule", "cylinder", "ellipsoid", "mesh", "plane", "sphere"}
# MJCF kinds whose `fromto` (end points) Drake does not read.
_WITHOUT_FROMTO = ("box", "ellipsoid")
_WORLD = "world"


@dataclass(frozen=True)
class StatedShape:
    """Collision shape in a description.

    Attributes:
        link: Its name; "world" for MJCF's `worldbody`, "" for a body of MJCF without a name.
        element: Its own name, or "".
        kind: Such as "box".
    """

    link: str
    element: str
    kind: str


def stated_shapes(root: ET.Element) -> list[StatedShape]:
    """Return every collision shape in a description itself."""
    return list(_mjcf_shapes(root) if root.tag == "mujoco" else _link_shapes(root))


def collision_counts(plant: Any, bodies: Sequence[BodyIndex]) -> Counter[str]:
    """Return the number of collision shapes of some bodies, by the body's name."""
    counts: Counter[str] = Counter()
    for index in bodies:
        body = plant.get_body(index)
        counts[body.name()] += len(plant.GetCollisionGeometriesForBody(body))
    return counts


def validate_num_shapes(
    plant: Any,
    instances: Sequence[ModelInstanceIndex],
    stated: Sequence[StatedShape],
    before: Counter[str],
    file: Path,
) -> None:
    """Raise unless the plant has every collision shape of a description.

    Args:
        plant: With the model.
        instances: The model's.
        stated: By the description.
        before: Counts of the world's body before the model was added.
        file: The description.

    Raises:
        ModelInvalid: Shapes of a link are missing; it names the link, the elements and their kinds.
    """
    world = plant.world_body().index()
    bodies = [index for instance in instances for index in plant.GetBodyIndices(instance)]
    counts = collision_counts(plant, [*(i for i in bodies if i != world), world]) - before
    named = {shape.link for shape in stated}
    nameless = sum(counts[name] for name in counts if name not in named and name != _WORLD)
    for link in sorted(named):
        link_shapes = [shape for shape in stated if shape.link == link]
        count = counts[link] if link else nameless
        if count < len(link_shapes):
            raise _missing_shapes_error(file, link, link_shapes, count)


def _missing_shapes_error(
    file: Path, link: str, own: Sequence[StatedShape], count: int
) -> ModelInvalid:
    unsupported = [shape for shape in own if shape.kind not in _SUPPORTED_KINDS] or list(own)
    elements = [f"{shape.element or 'without a name'} ({shape.kind})" for shape in unsupported]
    reason = f"link {link!r}: {count} of its {len(own)} collision shapes are read; not read: "
    reason += ", ".join(elements) + ". Describe it by boxes, spheres, cylinders, capsules, "
    reason += "ellipsoids or meshes"
    evidence = {"file": str(file), "reason": reason, "link": link, "elements": elements}
    return ModelInvalid(f"{file.name}: {reason}", evidence)


def _link_shapes(root: ET.Element) -> Iterator[StatedShape]:
    """Yield the shapes of URDF or SDF."""
    for link in root.iter("link"):
        if link.get("drake_ignore") == "true":
            continue
        for collision in link.findall("collision"):
            for kind in _kinds(collision.find("geometry")):
                yield StatedShape(link.get("name", ""), collision.get("name", ""), kind)


def _kinds(geometry: ET.Element | None) -> list[str]:
    """Return the kinds of the shapes of one geometry; Drake's own tags replace others."""
    tags = [] if geometry is None else [child.tag for child in geometry if child.tag != "empty"]
    own = [tag for tag in tags if "drake" in tag]
    return [tag.rpartition("}")[2].removeprefix("drake:") for tag in own or tags]


def _mjcf_shapes(root: ET.Element) -> Iterator[StatedShape]:
    defaults = MjcfDefaults(root)
    holders = [(body.get("name", ""), body) for body in root.iter("body")]
    holders += [(_WORLD, body) for body in root.findall("worldbody")]
    for link, holder in holders:
        for geom in holder.findall("geom"):
            masks = [defaults.get(geom, mask, "1") for mask in ("contype", "conaffinity")]
            if masks != ["0", "0"]:
                kind = defaults.get(geom, "type", "sphere")
                if defaults.get(geom, "fromto") and kind in _WITHOUT_FROMTO:
                    kind += " fromto"
                yield StatedShape(link, geom.get("name", ""), kind)
