"""write_bundle(): a finished plan as a ZIP file; the same plan gives the same bytes."""

import io
import json
from collections.abc import Iterator, Mapping
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from service.jobs.job import Job
from service.jobs.json_steps import decode, members_of
from service.jobs.json_text import Encoded
from service.plans.bundle import contents
from service.plans.bundle.contents import FailureBrief, Manifest
from service.scenes.store.document_artifact import document_of, files_of
from service.versions import processor

# The first instant that a ZIP file can name: when it was written is not part of it.
_NO_TIME = (1980, 1, 1, 0, 0, 0)
_READABLE = 0o644 << 16


def bundled_outcome(text: str) -> dict[str, Any]:
    """Return what a bundle has of a `PlanOutcome`, with its large `result` as it was written."""
    return {
        name: Encoded(part) if name == "result" else decode(part)
        for name, part in members_of(text)
        if name in {"result", "digest", "cut_short"}
    }


def write_bundle(job: Job, artifacts: Mapping[str, bytes]) -> bytes:
    """Return the bundle of a plan that succeeded or failed.

    Args:
        job: The plan; its result, if it has one, is a `bundled_outcome`.
        artifacts: All that its task reads, by sha256.
    """
    written = io.BytesIO()
    with ZipFile(written, "w", ZIP_DEFLATED) as archive:
        for name, content in _entries(job, artifacts):
            entry = ZipInfo(name, _NO_TIME)
            entry.compress_type, entry.external_attr = ZIP_DEFLATED, _READABLE
            archive.writestr(entry, content)
    return written.getvalue()


def _entries(job: Job, artifacts: Mapping[str, bytes]) -> Iterator[tuple[str, str | bytes]]:
    manifest = _manifest(job)
    outcome = contents.RESULT if manifest.failure is None else contents.FAILURE
    ended = "succeeded" if manifest.failure is None else f"failed: {manifest.failure.code}"
    document = artifacts[job.payload["scene"]["document"]]
    yield (
        contents.README,
        contents.README_TEXT.format(plan=job.id, ended=ended, outcome=outcome),
    )
    yield contents.MANIFEST, manifest.model_dump_json(indent=1) + "\n"
    yield contents.REQUEST, _json(job.payload["request"])
    # Not indented, which takes a second for each megabyte.
    yield outcome, f"{job.result['result'].text}\n" if job.result else _json(job.failure)
    yield contents.SCENE, document_of(document).text
    yield contents.WORK, _json(job.payload)
    yield contents.TEST, contents.TEST_TEXT.format(plan=job.id)
    named = _named_files(document)
    for digest, content in sorted(artifacts.items()):
        name = named.get(digest, f"{contents.ARTIFACTS}/{digest}.json")
        yield name, content


def _manifest(job: Job) -> Manifest:
    failure, result = job.failure, job.result or {}
    return Manifest.model_validate({
        "plan": job.id,
        "task": job.task,
        "state": job.state,
        "scene_digest": job.payload["scene"]["digest"],
        "digest": result.get("digest"),
        "failure": failure and FailureBrief(**_brief(failure)),
        "cut_short": result.get("cut_short") or [],
        "versions": job.made_by or {},
        "processor": processor(),
    })


def _brief(failure: Mapping[str, Any]) -> dict[str, str]:
    return {name: str(failure.get(name) or "") for name in FailureBrief.model_fields}


def _named_files(document: bytes) -> dict[str, str]:
    """Return names for the files of a scene by sha256: robot or object, then the path as it was."""
    return {
        digest: f"{contents.FILES}/{owner}/{path}"
        for owner, kept in sorted(files_of(document).items(), reverse=True)
        for path, digest in kept["sha256"].items()
    }


def _json(content: Any) -> str:
    return json.dumps(content, indent=1) + "\n"
