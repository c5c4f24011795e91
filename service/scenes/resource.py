"""Scene records as resources."""

from collections.abc import Sequence

from fastapi import Response
from pydantic import TypeAdapter

from service.api.responses import passed_on
from service.jobs.json_text import Encoded
from service.scenes.etags import etag_of
from service.scenes.models.scene import SceneBrief
from service.scenes.models.verdicts import ExecutionVerdict
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


def edited_response(record: SceneRecord, verdicts: Sequence[ExecutionVerdict]) -> Response:
    """Return the answer that has a scene in full, and what an edit means for executions."""
    text = scene_text(record).text
    executions = TypeAdapter(list[ExecutionVerdict]).dump_json(list(verdicts)).decode("ascii")
    told = Encoded(f'{text[:-1]},"executions":{executions}}}')
    return passed_on(told, 200, {"ETag": etag_of(record)})


def scene_response(record: SceneRecord, status: int = 200, location: str | None = None) -> Response:
    """Return the answer that has a scene in full."""
    headers = {"ETag": etag_of(record)} | ({} if location is None else {"Location": location})
    return passed_on(scene_text(record), status, headers)
