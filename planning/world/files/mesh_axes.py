"""to_z_up(): transform of a mesh's units and axes to metres with z up, as Drake does with glTF."""

from io import BytesIO
from xml.etree import ElementTree as ET

import numpy as np
from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import iterparse
from jaxtyping import Float64

from planning.world.documents.xml_file import NO_ENTITIES

# Rows: the sources of x, y and z (COLLADA 1.4.1, `up_axis`: right, up and in of each).
_TO_Z_UP = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z_UP": np.eye(3),
}


def to_z_up(content: bytes, suffix: str) -> Float64[np.ndarray, "4 4"]:
    """Return the matrix that maps a mesh's vertices to metres with z up.

    COLLADA states its unit and its axes; glTF is in metres with y up (glTF 2.0, section 3.4); STL,
    PLY and OFF state neither and are taken as they are.

    Args:
        content: Of the file.
        suffix: Its ending, in small letters.

    Raises:
        ValueError: The COLLADA file states an invalid unit or axis, or has a document type.
    """
    matrix = np.eye(4)
    if suffix in (".glb", ".gltf"):
        matrix[:3, :3] = _TO_Z_UP["Y_UP"]
    elif suffix == ".dae":
        metres, axis = collada_asset(content)
        matrix[:3, :3] = metres * _TO_Z_UP[axis]
    return matrix


def collada_asset(content: bytes) -> tuple[float, str]:
    """Return the length of a COLLADA file's unit [m] and its `up_axis`; 1 and Y_UP unless stated.

    Raises:
        ValueError: They are invalid, or the file has a document type, in any encoding.
    """
    try:
        for _, element in iterparse(BytesIO(content), events=("end",), forbid_dtd=True):
            if element.tag.rpartition("}")[2] == "asset":
                return _unit(element), _axis(element)
    except DefusedXmlException as fault:
        raise ValueError(NO_ENTITIES) from fault
    return 1.0, "Y_UP"


def _unit(asset: ET.Element) -> float:
    unit = asset.find("{*}unit")
    metres = float("1" if unit is None else unit.get("meter", "1"))
    if not 0 < metres < np.inf:
        message = f"its unit has {metres} metres"
        raise ValueError(message)
    return metres


def _axis(asset: ET.Element) -> str:
    axis = (asset.findtext("{*}up_axis") or "Y_UP").strip()
    if axis not in _TO_Z_UP:
        message = f"its up_axis is {axis!r}; known ones: {list(_TO_Z_UP)}"
        raise ValueError(message)
    return axis
