"""Checks of a certificate in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from service.studio.texts import millimetres, short

# Shares of limits are told in percent.
_SHARE = "1"
_OF_LIMITS = {"velocity", "acceleration", "jerk", "torque"}
# What checks are called, and what they mean, where the name does not say it.
_MEANINGS = {
    "form": ("well formed", "all numbers are finite, times increase, rotations are rotations"),
    "start": ("start", "begins where it was asked to"),
    "goal": ("goal", "ends where it was asked to"),
    "rest": ("rest at both ends", "begins and ends at rest"),
    "continuity": ("no jumps", "position does not jump"),
    "velocity continuity": ("no kinks", "velocity does not jump"),
    "position": ("position limits", "room that the nearest joint has left to its limit"),
    "velocity": ("velocity limits", "the share of its limit that the fastest joint uses"),
    "acceleration": ("acceleration limits", "the share of its limit that a joint uses at most"),
    "jerk": ("jerk limits", "the share of its limit that a joint uses at most"),
    "torque": ("torque limits", "the share of its limit that a joint uses at most"),
    "clearance": ("clearance", "the smallest distance that was measured"),
}


@dataclass(frozen=True)
class CheckWords:
    """What is said of a check.

    Attributes:
        name: Its name, and whether it failed.
        value: What was found, in one or two words, and when.
        hint: All of it.
        curve: The curve that shows it, if one does.
    """

    name: str
    value: str
    hint: str
    curve: str | None


def words_of(check: Mapping[str, Any]) -> CheckWords:
    """Return what is said of a check of the API."""
    name, time = check["name"], float(check["time"])
    called, meaning = _MEANINGS.get(name, (name, ""))
    mark = "✓ " if check["passed"] else "✗ failed: "
    value = _value(check)
    where = "–".join(map(short, check["where"].split("-"))) if check["where"] else ""  # noqa: RUF001
    verb = "passed" if check["passed"] else "failed"
    unit = "" if check["unit"] == _SHARE else f" {check['unit']}"
    hint = f"{verb}: {check['value']:.4g}{unit}, bound {check['bound']:.4g}{unit}"
    about = f"{meaning}; " if meaning else ""
    kind = name.split(" ")[0]
    curve = {"tool_speed": "tool speed", "position": "position", "clearance": "clearance"}.get(
        kind, kind if name in _OF_LIMITS else None
    )
    return CheckWords(
        name=f"{mark}{called}",
        value=f"{value} at {time:.2f} s",
        hint=f"{about}{hint}{', ' + where if where else ''}, at {time:.3f} s",
        curve=curve,
    )


def _value(check: Mapping[str, Any]) -> str:
    name, value, unit = check["name"], float(check["value"]), check["unit"]
    if name == "clearance":
        return millimetres(value)
    if unit == _SHARE and abs(value) > 1e-3:
        return f"{100 * value:.0f} %"
    if name == "position":
        return f"{abs(value):.3g} {unit} {'to the limit' if value <= 0 else 'beyond it'}"
    if abs(value) <= abs(float(check["bound"])):
        return "kept"
    return f"{value:.3g} {unit}"
