"""xml_root(): XML parser for untrusted input, with the reason of a refusal.

For any encoding: document types are refused by the parser that meets them (defusedxml), so that no
entity is ever defined.
"""

from xml.etree import ElementTree as ET

import defusedxml.ElementTree as DefusedET
from defusedxml.common import DefusedXmlException

MAX_BYTES = 20_000_000
# Drake's own parser allows 500; a body inside a body is one level.
MAX_DEPTH = 400
# Reason of a refusal.
NO_ENTITIES = "document types and entities are not allowed"


def xml_root(content: bytes) -> ET.Element:
    """Return the root of an XML text.

    Raises:
        ValueError: It is not XML, too large or too deep, or has a document type.
    """
    if len(content) > MAX_BYTES:
        message = f"it has {len(content)} bytes; at most {MAX_BYTES} are read"
        raise ValueError(message)
    try:
        root: ET.Element = DefusedET.fromstring(content, forbid_dtd=True)
    except DefusedXmlException as fault:
        raise ValueError(NO_ENTITIES) from fault
    except (ET.ParseError, ValueError, LookupError) as fault:
        message = f"not XML: {fault}"
        raise ValueError(message) from fault
    _validate_depth(root)
    return root


def _validate_depth(root: ET.Element) -> None:
    level = [root]
    for _ in range(MAX_DEPTH):
        level = [child for element in level for child in element]
        if not level:
            return
    message = f"<{level[0].tag}> is nested more than {MAX_DEPTH} deep"
    raise ValueError(message)
