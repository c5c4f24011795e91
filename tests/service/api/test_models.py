"""Booleans in bodies are true or false: no text, no numbers, wherever they stand."""

from collections.abc import Iterator
from contextlib import suppress
from functools import cache

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

import service.app
from planning.world.documents.strict_model import StrictModel
from service.api.models import RequestModel
from service.plans.models.search import Car

assert service.app  # it imports every wire type there is


def descendants(base: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for child in base.__subclasses__():
        yield child
        yield from descendants(child)


@cache
def booleans() -> dict[str, TypeAdapter]:
    """Return the fields of all bodies that may be booleans and nothing else."""
    fields = {
        f"{model.__name__}.{name}": TypeAdapter(field.rebuild_annotation())
        for base in (RequestModel, StrictModel)
        for model in descendants(base)
        for name, field in model.model_fields.items()
    }
    return {
        name: adapter
        for name, adapter in fields.items()
        if adapter.json_schema().get("type") == "boolean"
    }


def test_every_body_was_looked_at():
    looked_at = {"Car.reverse", "Search.approximate", "ObjectDocument.movable"}
    assert looked_at <= set(booleans())


@pytest.mark.parametrize("wrong", ["no", "true", "1", 0, 1, 1.0, None])
def test_lookalikes_are_no_booleans(wrong):
    taken = []
    for name, adapter in booleans().items():
        assert adapter.validate_json("true") is True, name
        with suppress(ValidationError):
            taken.append((name, adapter.validate_python(wrong)))
    assert taken == []


def test_a_car_is_told_what_is_wrong():
    with pytest.raises(ValidationError, match="reverse"):
        Car.model_validate({"turning_radius": 1, "reverse": "no"})
