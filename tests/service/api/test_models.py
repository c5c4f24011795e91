"""Booleans in bodies are true or false, numbers are finite numbers, wherever they stand."""

from collections.abc import Iterator
from contextlib import suppress
from functools import cache

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

import service.app
from planning.world.documents.strict_model import StrictModel
from service.api.models import Integer, Positions, Real, RequestModel, Scale
from service.plans.models.search import Car

assert service.app  # it imports every model there is


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


@pytest.mark.parametrize("wrong", ["1", True, None, float("nan"), float("inf"), [1], {}])
@pytest.mark.parametrize("kind", [Real, Integer, Scale])
def test_lookalikes_are_refused(kind, wrong):
    with pytest.raises(ValidationError):
        TypeAdapter(kind).validate_python(wrong)


def test_whole_numbers_are_integers_and_reals():
    assert TypeAdapter(Integer).validate_python(3.0) == 3
    assert TypeAdapter(Real).validate_python(3) == 3.0
    with pytest.raises(ValidationError):
        TypeAdapter(Integer).validate_python(3.5)


@pytest.mark.parametrize("wrong", [0, -0.1, 1.0001])
def test_scales_are_in_zero_to_one(wrong):
    with pytest.raises(ValidationError):
        TypeAdapter(Scale).validate_python(wrong)


def test_positions_are_bounded():
    for wrong in ([], [0.0] * 257, [1e7], ["0"]):
        with pytest.raises(ValidationError):
            TypeAdapter(Positions).validate_python(wrong)
