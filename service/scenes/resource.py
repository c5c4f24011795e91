"""Scene records as resources."""

from service.jobs.json_text import Encoded
from service.scenes.models.scene import SceneBrief
from service.scenes.records import SceneRecord


def scene_text(record: SceneRecord) -> Encoded:
    """Return a scene in full, as the schema `Scene` has it.

    What grows with the scene goes out as the text that it was made as: it is not read here.
    """
    brief = SceneBrief.model_validate(record).model_dump_json(ensure_ascii=True)
    summary = record.summary.model_copy(update={"files": record.summary.files or {}})
    content = summary.model_dump_json(ensure_ascii=True, exclude_none=True)
    unchecked, document = record.loaded.unchecked.text, record.loaded.document.text
    return Encoded(f'{brief[:-1]},{content[1:-1]},"unchecked":{unchecked},"document":{document}}}')
