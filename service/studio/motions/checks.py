"""Checks of a certificate in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from service.studio.texts import short

# Shares of limits are told in percent.
_SHARE = "1"
_OF_LIMITS = {"velocity", "acceleration", "jerk", "torque"}


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
    mark = "" if check["passed"] else "failed: "
    value = _value(check)
    where = "–".join(map(short, check["where"].split("-"))) if check["where"] else ""  # noqa: RUF001
    verb = "passed" if check["passed"] else "failed"
    unit = "" if check["unit"] == _SHARE else f" {check['unit']}"
    hint = f"{verb}: {check['value']:.4g}{unit}, bound {check['bound']:.4g}{unit}"
    kind = name.split(" ")[0]
    curve = {"tool_speed": "tool speed", "position": "position", "clearance": "clearance"}.get(
        kind, kind if name in _OF_LIMITS else None
    )
    return CheckWords(
        name=f"{mark}{name}",
        value=f"{value} at {time:.2f} s",
        hint=f"{hint}{', ' + where if where else ''}, at {time:.3f} s",
        curve=curve,
    )


def _value(check: Mapping[str, Any]) -> str:
    name, value, unit = check["name"], float(check["value"]), check["unit"]
    if name == "clearance":
        return f"{1000 * value:.1f} mm"
    if unit == _SHARE and abs(value) > 1e-3:
        return f"{100 * value:.0f} %"
    if name == "position":
        return f"{-value:.3g} inside" if value <= 0 else f"{value:.3g} outside"
    if abs(value) <= abs(float(check["bound"])):
        return "exact"
    return f"{value:.3g} {unit}"
