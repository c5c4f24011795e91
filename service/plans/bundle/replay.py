"""replay_bundle(): plan again what a bundle is of, and say whether the same bytes come out."""

import importlib
import json
import os
from contextvars import copy_context
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from service.jobs.host_folder import artifact_path, set_host_folder
from service.jobs.worker.context import SilentContext
from service.jobs.worker.protocol import MessageKind
from service.jobs.worker.run_task import TaskEnd, run_task
from service.plans.bundle.reader import Bundle, BundleInvalid, read_bundle
from service.versions import processor, versions

# Of the numbers of a result that differs, these are compared.
_NUMBERS = ("goal_index", "path", "trajectory.duration", "trajectory.positions")
_PROOF = ("certificate.proven", "certificate.min_clearance")


@dataclass(frozen=True)
class Replay:
    """What became of a bundle that was planned again.

    Attributes:
        plan: Id of the plan.
        expected: Its digest, or the code of its failure.
        found: What came out.
        differences: Of the result, in words; none if it is the same.
        other_versions: Name, version of then, version here; where they differ. The processor is
            among them: on another kind the same versions may give other bytes.
        cut_short: Stages that the clock ended early then, or here.
        detail: What the failure says that came out, if one did.
    """

    plan: str
    expected: str
    found: str
    differences: tuple[str, ...] = ()
    other_versions: tuple[tuple[str, str, str], ...] = ()
    cut_short: tuple[str, ...] = ()
    detail: str = ""

    @property
    def is_same(self) -> bool:
        """Whether the same bytes came out, or the same failure."""
        return self.expected == self.found

    @property
    def text(self) -> str:
        """All of it for people, a line each."""
        verdict = "the same" if self.is_same else "NOT the same"
        lines = [f"{self.plan}: {verdict}", f"  then: {self.expected}", f"  here: {self.found}"]
        lines += [f"  here: {self.detail}"] if self.detail and not self.is_same else []
        lines += [f"  differs: {text}" for text in self.differences]
        lines += [f"  {name}: {old}, here {new}" for name, old, new in self.other_versions]
        if self.cut_short and not self.is_same:
            lines.append(f"  the clock ended {', '.join(self.cut_short)}: bytes may differ by that")
        return "\n".join(lines)


def replay_bundle(path: Path) -> Replay:
    """Plan again what a bundle is of; nothing outside of it is read.

    Args:
        path: A ZIP file, or the folder that it was unpacked to.

    Raises:
        BundleInvalid: It is no bundle, is damaged, or is too large.
    """
    bundle = read_bundle(path)
    with TemporaryDirectory(prefix="wayproof-replay-") as folder:
        ended = copy_context().run(_run, bundle, Path(folder))
    return _compared(bundle, ended)


def _run(bundle: Bundle, folder: Path) -> TaskEnd:
    """Carry the task of a bundle out in this process."""
    importlib.import_module("service.plans.worker")  # carries the tasks out; has Drake with it
    set_host_folder(folder)
    for digest, content in bundle.artifacts.items():
        file = artifact_path(folder, digest)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    library = {"model_roots": [], "allow_paths": False}  # the files are in the bundle
    work = {**bundle.work, "library": library}
    if work.get("cores") is not None:
        work["cores"] = {"count": os.cpu_count() or 1}
    ended = run_task(bundle.manifest.task, json.dumps(work), SilentContext())
    if ended.kind is MessageKind.CRASH:
        message = f"it could not be planned here: {ended.text}"
        raise BundleInvalid(message)
    return ended


def _compared(bundle: Bundle, ended: TaskEnd) -> Replay:
    manifest, found = bundle.manifest, json.loads(ended.text)
    failure = None if manifest.failure is None else manifest.failure.code
    is_result = ended.kind is MessageKind.RESULT
    differences: list[str] = []
    if is_result and manifest.digest not in {None, found["digest"]}:
        differences = _differences(bundle.result or {}, found["result"])
    cut_short = {*manifest.cut_short, *(found["cut_short"] if is_result else ())}
    return Replay(
        plan=manifest.plan,
        expected=manifest.digest or f"failure {failure}",
        found=found["digest"] if is_result else f"failure {found['code']}",
        differences=tuple(differences),
        other_versions=_other_versions({**manifest.versions, "processor": manifest.processor}),
        cut_short=tuple(sorted(cut_short)),
        detail="" if is_result else found["detail"],
    )


def _other_versions(then: dict[str, str]) -> tuple[tuple[str, str, str], ...]:
    here = {**versions(), "processor": processor()}
    return tuple(
        (name, then.get(name, "none"), here.get(name, "none"))
        for name in sorted(then.keys() | here.keys())
        if then.get(name) != here.get(name)
    )


def _differences(then: dict[str, Any], here: dict[str, Any]) -> list[str]:
    """Return what differs of two results that have different digests."""
    found: list[str] = []
    for name in (*_NUMBERS, *_PROOF):
        old, new = _member(then, name), _member(here, name)
        if old != new:
            found.append(f"{name}: {_short(old)}, here {_short(new)}")
    return found or ["numbers that the result does not show: the exact trajectory or its proof"]


def _member(content: Any, name: str) -> Any:
    for part in name.split("."):
        content = content.get(part) if isinstance(content, dict) else None
    return content


def _short(value: Any) -> str:
    if isinstance(value, list):
        return f"{len(value)} rows, the last {str(value[-1])[:80]}" if value else "none"
    return str(value)
