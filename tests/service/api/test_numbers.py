"""Numbers on the wire are finite numbers: never text, never booleans."""

import pytest
from pydantic import TypeAdapter, ValidationError

from service.api.numbers import Integer, Positions, Real, Scale


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
