"""Words of a form: what a field is called, with its unit, and the form in which it is written."""

import json
import re
from typing import Any

import yaml

from service.studio.forms.fields import Field

# In a description: of what it is a number.
_UNIT = re.compile(r"\[([^\]]{1,24})\]")

# Names that are no words.
_WORDS = {"ik": "inverse kinematics", "num": "number of"}


class FormError(ValueError):
    """What was filled in cannot be read."""


def label_of(field: Field) -> str:
    """Return what a field is called: its name in words, and the unit that its text has."""
    return f"{spoken(field.name)}{unit_of(field)}"


def spoken(name: str) -> str:
    """Return the name of a field in words."""
    words = " ".join(_WORDS.get(word, word) for word in name.split("_"))
    return words[:1].upper() + words[1:]


def unit_of(field: Field) -> str:
    """Return the unit of a field, as it stands behind its name."""
    unit = _UNIT.search(field.text)
    return "" if unit is None else f" [{unit[1]}]"


def written(value: Any) -> str:
    """Return a list or a map as a person can change it; nothing for None."""
    return "" if value is None else json.dumps(value)


def read(text: str, name: str) -> Any:
    """Return what a list or a map says, in JSON or in YAML; None for nothing.

    Args:
        text: By hand.
        name: Of the field, for the message.

    Raises:
        FormError: It is neither.
    """
    if not text.strip():
        return None
    try:
        return json.loads(text)  # YAML 1.1 takes 1e-3 for a word
    except ValueError:
        pass
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as fault:
        message = f"{spoken(name)} cannot be read: {text[:80]!r} is no list and no map"
        raise FormError(message) from fault
