"""failed(): why something failed: one plain sentence, and all that the server says, folded."""

import math
import re
from collections.abc import Mapping
from html import escape
from typing import Any

from service.studio import texts
from service.studio.motions.verdict import meeting

# Turned less than this is not worth a word [rad].
_LITTLE = math.radians(0.5)
_TINY = re.compile(r"\b\d+(?:\.\d+)?e-(?:0[4-9]|[1-9]\d)\b")
_SAME = re.compile(r"\b(\d+(?:\.\d+)?) to \1\b")
_ROBOT = re.compile(r"\b\w+::(?=\w)")
_METRES = re.compile(r"(-?\d+\.\d+) m where 0 is the bound")
_PLACE = re.compile(r"^body\.\S+?(\w+)(?:\.\d+)?: ")
# A first sentence that is longer is cut after a clause.
_LONG = 160


def failed(code: str, detail: str, evidence: Mapping[str, Any] | None = None) -> str:
    """Return why something failed, as HTML.

    Args:
        code: Of the failure.
        detail: The server's words.
        evidence: As the API has it, if there is any.
    """
    head = headline(code, detail, evidence)
    return texts.lines(f"<b>{escape(head)}</b>{texts.folded(code, plain(detail))}", "bad")


def headline(code: str, detail: str, evidence: Mapping[str, Any] | None = None) -> str:
    """Return the short sentence of a failure."""
    found = evidence or {}
    if code == "goal_in_collision":
        return _goal_collides(found)
    if code == "not_certified" and found.get("check") == "clearance" and found.get("pair"):
        return f"{meeting(found['pair'], float(found['value']), float(found['time']))}."
    said = plain(detail)
    if len(said) > _LONG:
        said = re.split(r"[;:] ", said, maxsplit=1)[0]
    return f"{said[:1].upper()}{said[1:]}" if said else code.replace("_", " ").capitalize()


def plain(detail: str) -> str:
    """Return a server's words with fewer digits, and without the robot before each link."""
    said = _SAME.sub(r"\1", _TINY.sub("0", detail))
    said = _METRES.sub(lambda found: texts.millimetres(float(found[1])), said)
    said = _PLACE.sub(lambda found: f"{found[1].replace('_', ' ')}: ", said)
    return _ROBOT.sub("", said)


def _goal_collides(evidence: Mapping[str, Any]) -> str:
    funnel, relaxation = evidence.get("funnel") or {}, evidence.get("relaxation") or {}
    tried = int(funnel.get("within_limits") or 1)
    told = f"The goal collides (all {tried} arm poses)." if tried > 1 else "The goal collides."
    obstacles = [pair for pair in relaxation.get("obstacles") or () if pair["depth"] > 0]
    if obstacles:
        deepest = max(obstacles, key=lambda pair: pair["depth"])
        a, b = map(texts.short, deepest["bodies"])
        told += f" Least: {a} with {b}, {texts.millimetres(deepest['depth'])}."
    nearest = evidence.get("nearest") or {}
    if nearest.get("translation_error") is not None:
        told += f" Nearest free pose: {_away(nearest)} away."
    return told


def _away(nearest: Mapping[str, Any]) -> str:
    turned = float(nearest.get("rotation_error") or 0.0)
    moved = texts.millimetres(float(nearest["translation_error"]))
    return moved if turned < _LITTLE else f"{moved} and {math.degrees(turned):.0f}°"
