"""The answers of the service to the corpus, as they are compared."""

import csv
import hashlib
import io
import json
import re
import tempfile
import threading
import warnings
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.golden.service.calls import Call, filled
from tests.golden.service.masks import Masks, lasting_events, rounded
from tests.golden.service.motion_calls import LAST_CALLS, MOTION_CALLS, SEVERAL_CALLS
from tests.golden.service.plan_calls import PLAN_CALLS
from tests.golden.service.question_calls import QUESTION_CALLS
from tests.golden.service.refused_calls import REFUSED_CALLS
from tests.golden.service.resource_calls import RESOURCE_CALLS
from tests.golden.service.scene_calls import FIRST_CALLS
from tests.golden.service.summary import summary
from tests.world.meshcat_messages import overlay

CALLS: tuple[Call, ...] = (
    *FIRST_CALLS,
    *QUESTION_CALLS,
    *PLAN_CALLS,
    *MOTION_CALLS,
    *REFUSED_CALLS,
    *LAST_CALLS,
    *RESOURCE_CALLS,
    *SEVERAL_CALLS,
)
_REPOSITORY = Path(__file__).parents[3]
# What all answers have alike: tests/service/security/test_response_headers.py shows it.
_ALIKE = {
    "content-security-policy",
    "referrer-policy",
    "x-content-type-options",
    "x-frame-options",
}
# And what is the transport's.
_UNTOLD = {"content-length", "date", "server", "x-request-id", *_ALIKE}
_FINAL = {"succeeded", "failed", "canceled", "aborted"}
_WORDS = re.compile(r">([^<>]*\S[^<>]*)</text>")


def client(folder: Path) -> Any:
    """Return a client of a service in this process that does one thing at a time, when entered."""
    from service.app import create_app
    from service.settings import Settings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from starlette.testclient import TestClient
    return TestClient(create_app(Settings(**_SLOTS, data_dir=folder)), follow_redirects=False)


# No deadline may cut anything short, and what is found must not depend on the number of processors.
_SLOTS: dict[str, Any] = {
    "engine": "inline",
    "host": "127.0.0.1",
    "database_url": None,
    "plan_slots": 1,
    "query_slots": 1,
    "search_processes": 1,
    "max_queued": 1,
    "query_timeout": 600,
    "best_grace": 60,
}


def answers() -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the name of each call and what is compared of its answer."""
    with tempfile.TemporaryDirectory() as name, client(Path(name)) as service:
        folder = str(Path(name).resolve())
        masks = Masks({folder: "<data>", str(_REPOSITORY): "<repository>"})
        given: dict[str, Any] = {}
        for call in CALLS:
            answer = ask(service, call, given)
            if answer.headers.get("content-type") == "application/json" and answer.content:
                given[call.name] = answer.json()
            yield call.name, _compared(call, answer, masks)


_PAUSE = threading.Event()


def ask(service: Any, call: Call, given: dict[str, Any]) -> Any:
    """Return the answer to a call; `given` has earlier answers by the names of their calls."""
    ids = {name: part["id"] for name, part in given.items() if "id" in part}
    body = filled(call.body, given)
    sent = {"content": body} if isinstance(body, bytes) else {"json": body} if body else {}
    path = call.path.format_map(ids)
    while True:
        answer = service.request(call.method, path, headers=call.headers, **sent)
        if call.until is None or _is_there(call.until, answer.json()):
            return answer
        _PAUSE.wait(0.01)  # what is waited for needs this process as well


def _is_there(until: tuple[str, str], found: dict[str, Any]) -> bool:
    if found["unrecorded"]:
        return False
    if found[until[0]] != until[1] and found["state"] in _FINAL:
        message = f"{found['id']} has ended before its {until[0]} was {until[1]}: {found}"
        raise AssertionError(message)
    return bool(found[until[0]] == until[1])


def _compared(call: Call, answer: Any, masks: Masks) -> dict[str, Any]:
    kind = answer.headers.get("content-type", "").partition(";")[0]
    body = _readers().get(kind, _json)(answer, masks, call.is_moving) if answer.content else None
    headers = {
        name: masks.text(value)
        for name, value in sorted(answer.headers.items())
        if name not in _UNTOLD
    }
    if "server-timing" in headers:
        headers["server-timing"] = re.sub(r"dur=[0-9.]+", "dur=<seconds>", headers["server-timing"])
    if "retry-after" in headers:
        headers["retry-after"] = "<seconds>"
    return {"status": answer.status_code, "headers": headers, "body": summary(body)}


def _readers() -> dict[str, Any]:
    return {
        "text/event-stream": _events,
        "text/html": _page,
        "application/zip": _bundle,
        "text/csv": _table,
        "image/svg+xml": _drawing,
        "text/plain": _lines,
    }


def _json(answer: Any, masks: Masks, is_moving: bool) -> Any:
    return masks.document(answer.json(), is_moving=is_moving)


def _events(answer: Any, masks: Masks, is_moving: bool) -> Any:
    blocks = [block for block in answer.text.split("\n\n") if block.strip()]
    events = [dict(line.split(": ", 1) for line in block.splitlines()) for block in blocks]
    kept = lasting_events(events)
    for event in kept:
        event["data"] = masks.document(json.loads(event["data"]))
        event["id"] = "<number>"  # those that are left out are counted, and come as time passes
    return kept


def _page(answer: Any, masks: Masks, is_moving: bool) -> Any:
    if "<h2>" in answer.text:  # for printing: what changes from run to run is in the tables
        return {"headings": re.findall(r"<h2>(.*?)</h2>", answer.text)}
    if "const told = " not in answer.text:
        return {"sha256": hashlib.sha256(answer.content).hexdigest()}
    told = masks.document(overlay(answer.text))
    return {"told": told, "digits": len(str(len(answer.content)))}


def _bundle(answer: Any, masks: Masks, is_moving: bool) -> Any:
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        manifest = masks.document(json.loads(archive.read("bundle.json")))
        names = [re.sub(r"\b[0-9a-f]{64}\b", "<sha256>", name) for name in archive.namelist()]
    return {"names": names, "manifest": {**manifest, "processor": "<processor>"}}


def _table(answer: Any, masks: Masks, is_moving: bool) -> Any:
    header, *rows = csv.reader(io.StringIO(answer.text))
    return {"header": header, "rows": [[rounded(float(cell)) for cell in row] for row in rows]}


def _drawing(answer: Any, masks: Masks, is_moving: bool) -> Any:
    return {"words": _WORDS.findall(answer.text), "digits": len(str(len(answer.content)))}


def _lines(answer: Any, masks: Masks, is_moving: bool) -> Any:
    """Return the names of all metrics and the numbers of jobs; the others depend on the clock."""
    lines = masks.text(answer.text).splitlines()
    return [line for line in lines if line.startswith(("# ", "wayproof_jobs{"))]
