"""verdict_of(): what is known of a motion in the newest revision of its scene, in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from service.studio import texts

# Nearer than this without a margin is worth a warning [m].
_NARROW = 0.001
_ADVICE = "No margin is set, so it may pass this near: set a Margin in Options."


@dataclass(frozen=True)
class Proof:
    """A certificate, and what it is of.

    Attributes:
        certificate: As the API has it.
        duration: Of the motion [s].
        revision: Of the scene in which it was made.
        has_margin: Whether a distance was asked to be kept.
    """

    certificate: Mapping[str, Any]
    duration: float
    revision: int
    has_margin: bool


def verdict_of(proof: Proof, newest: int) -> str:
    """Return what is said of a motion, as HTML.

    Args:
        proof: The newest one.
        newest: Revision that the scene has now.
    """
    if not proof.certificate["proven"]:
        return _box("bad", f"Not proven in revision {proof.revision}", _failed(proof))
    if proof.revision != newest:
        since = f"the scene has changed since (revision {newest})"
        return _box("warn", f"Proven in revision {proof.revision}", since)
    gap = proof.certificate["min_clearance"]
    is_narrow = gap is not None and gap < _NARROW and not proof.has_margin
    told = f"{proof.duration:.2f} s · {clearance_of(proof.certificate)}"
    if is_narrow:
        return _box("warn", "Proven", told, _ADVICE)
    return _box("good", "Proven", told)


def clearance_of(certificate: Mapping[str, Any]) -> str:
    """Return how far everything stays apart: what is proven, what was measured, and of what."""
    gap = certificate["min_clearance"]
    if gap is None:
        return "nothing to hit"
    measured = certificate.get("observed_clearance")
    seen = (
        ""
        if measured is None
        else f" ({texts.millimetres(measured)} measured at {certificate['time']:.2f} s)"
    )
    pair = " and ".join(map(texts.short, certificate["pair"]))
    return f"at least {texts.millimetres(gap)} clear{seen} of {pair}"


def meeting(pair: list[str], distance: float, time: float) -> str:
    """Return that two bodies come too near: how near [m], and when [s]."""
    names = " and ".join(map(texts.short, pair))
    if distance < 0:
        return f"{names} collide by {texts.millimetres(-distance)} at {time:.2f} s"
    return f"{names} come within {texts.millimetres(distance)} at {time:.2f} s"


def _failed(proof: Proof) -> str:
    certificate = proof.certificate
    failed = [check for check in certificate["checks"] if not check["passed"]]
    told = [check["name"] for check in failed if check["name"] != "clearance"]
    if len(told) < len(failed) and certificate["pair"]:
        distance, time = certificate["observed_clearance"], certificate["time"]
        told.insert(0, meeting(certificate["pair"], distance, time))
    return ", ".join(told)


def _box(kind: str, head: str, told: str, advice: str = "") -> str:
    more = f"<br>{escape(advice)}" if advice else ""
    rest = f'<span style="color:{texts.COLORS["plain"]}">{escape(told)}</span>'
    bold = f'<b style="font-size:1.1em">{escape(head)}</b>'
    return texts.lines(f"{bold} · {rest}{more}", kind)
