"""Scene records to the wire."""

from typing import Any

from pydantic import TypeAdapter

from service.jobs.json_text import Encoded, encode
from service.scenes import models
from service.scenes.records import SceneBrief, SceneRecord
from service.scenes.summary_models import Group

_GROUPS = TypeAdapter(list[Group])


def scene_brief(record: SceneBrief) -> dict[str, Any]:
    """Return a scene without its content."""
    return {
        "id": record.id,
        "revision": record.revision,
        "digest": record.digest,
        "name": record.name,
        "created_at": record.created_at,
    }


def scene_text(record: SceneRecord) -> Encoded:
    """Return a scene in full, as the schema `Scene` has it.

    What grows with the scene goes out as the text that it was made as: it is not read here.
    """
    brief = models.SceneBrief.model_validate(scene_brief(record)).model_dump(mode="json")
    known = {
        name: part for name, part in record.summary.items() if name in models.Scene.model_fields
    }
    groups = _GROUPS.validate_python(known["groups"])
    known["groups"] = _GROUPS.dump_python(groups, mode="json", exclude_none=True)
    small = encode({"files": {}, **known, **brief})
    unchecked, document = record.loaded.unchecked.text, record.loaded.document.text
    return Encoded(f'{small[:-1]},"unchecked":{unchecked},"document":{document}}}')
