"""Sizes of an object's shape, by name, and the object with others."""

from collections.abc import Mapping, Sequence
from typing import Any


def sizes_of(entry: Mapping[str, Any]) -> dict[str, float]:
    """Return the sizes of an object by name [m]; none of shapes that have no simple ones."""
    shape = entry["shape"]
    if shape.get("box"):
        return dict(zip(("Side x [m]", "Side y [m]", "Side z [m]"), shape["box"], strict=True))
    if shape.get("sphere"):
        return {"Radius [m]": shape["sphere"]}
    for kind in ("cylinder", "capsule"):
        if shape.get(kind):
            return {"Radius [m]": shape[kind]["radius"], "Length [m]": shape[kind]["length"]}
    return {}


def with_size(entry: Mapping[str, Any], values: Sequence[float]) -> dict[str, Any]:
    """Return an object with other sizes.

    Args:
        entry: The object.
        values: As many as `sizes_of` names, in its order [m].
    """
    shape = dict(entry["shape"])
    if shape.get("box"):
        shape["box"] = list(values)
    elif shape.get("sphere"):
        shape["sphere"] = values[0]
    else:
        kind = "cylinder" if shape.get("cylinder") else "capsule"
        shape[kind] = {"radius": values[0], "length": values[1]}
    return {**entry, "shape": shape}
