"""Scene records as resources."""

from fastapi import Response

from service.api.responses import passed_on
from service.jobs.json_text import Encoded
from service.scenes.etags import etag_of
from service.scenes.models.scene import SceneBrief
from service.scenes.store.records import SceneRecord


def scene_text(record: SceneRecord) -> Encoded:
    """Return a scene in full, as the schema `Scene` has it.

    What grows with the scene goes out as the text that it was made as: it is not read here.
    """
    brief = SceneBrief.model_validate(record).model_dump_json(ensure_ascii=True)
    summary = record.summary.model_copy(update={"files": record.summary.files or {}})
    content = summary.model_dump_json(ensure_ascii=True, exclude_none=True)
    unchecked, document = record.loaded.unchecked.text, record.loaded.document.text
    return Encoded(f'{brief[:-1]},{content[1:-1]},"unchecked":{unchecked},"document":{document}}}')


def scene_response(record: SceneRecord, status: int = 200, location: str | None = None) -> Response:
    """Return the answer that has a scene in full."""
    headers = {"ETag": etag_of(record)} | ({} if location is None else {"Location": location})
    return passed_on(scene_text(record), status, headers)
