"""Digests are equal where contents are, and nowhere else."""

import importlib
import pkgutil
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

import planning
from planning.domain.value import Value, digest

INTEGERS = st.integers() | st.integers(2**53 - 4, 2**53 + 4) | st.integers(2**63, 2**80)
SCALARS = st.none() | st.booleans() | INTEGERS | st.floats(allow_nan=False) | st.text(max_size=4)
CONTENTS = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=2), inner, max_size=3)
    ),
    max_leaves=8,
)


def canonical(content: Any) -> Any:
    """What a digest is to tell apart, written in another way."""
    match content:
        case bool() | None:
            return repr(content)
        case int() | float():
            # Zero has two floats of different bits; an integer is the one without a sign.
            return "-0" if str(content) == "-0.0" else content
        case str():
            return f"'{content}'"
        case list():
            return ("list", *map(canonical, content))
        case _:
            return ("map", *sorted((key, canonical(item)) for key, item in content.items()))


@given(INTEGERS, INTEGERS)
@example(2**53, 2**53 + 1)
@example(-(2**53), -(2**53) - 1)
@example(10**400, 10**400 + 1)
@example(10**5000, 10**5000 + 1)
def test_integers_are_told_apart(a: int, b: int) -> None:
    assert (digest(a) == digest(b)) == (a == b)
    assert digest(a) == digest(a + 0)


@given(INTEGERS, st.floats(allow_nan=False))
@example(2**53 + 1, float(2**53))
@example(2**64, float(2**64))
def test_an_integer_is_the_float_that_equals_it(number: int, other: float) -> None:
    assume(str(other) != "-0.0")
    assert (digest(number) == digest(other)) == (number == other)


@given(CONTENTS, CONTENTS)
def test_contents_that_differ_have_other_digests(a: Any, b: Any) -> None:
    assert (digest(a) == digest(b)) == (canonical(a) == canonical(b))


def test_lengths_and_names_do_not_run_into_each_other() -> None:
    contents = [["1"], [1], [["1"]], ["", "1"], ["1", ""], ["list(1)"], [[], "1"], [["1"], []]]
    assert len({digest(content) for content in contents}) == len(contents)


@pytest.mark.parametrize(
    "array",
    [
        np.array([object()]),
        np.array([1.0], dtype=np.longdouble),
        np.array([(1, 2.0)], dtype=[("a", "i4"), ("b", "f8")]),
        np.array(["2020-01-01"], dtype="datetime64[D]"),
    ],
)
def test_arrays_whose_bytes_are_not_their_content_have_none(array: Any) -> None:
    with pytest.raises(TypeError, match="not a value"):
        digest(array)
    with pytest.raises(TypeError, match="not a value"):
        digest(array[0])


def test_numbers_of_numpy_are_those_of_python() -> None:
    assert digest(np.int64(2**53 + 1)) == digest(2**53 + 1)
    assert digest(np.uint64(2**64 - 1)) == digest(2**64 - 1) != digest(2**64)
    assert digest(np.float32(0.1)) == digest(float(np.float32(0.1)))


def test_text_that_is_no_unicode_has_a_digest() -> None:
    assert digest("\udce9") != digest("\udcea")


def values_of(kind: type[Value]) -> Iterator[type[Value]]:
    for below in kind.__subclasses__():
        yield below
        yield from values_of(below)


def test_no_two_classes_of_values_share_a_name() -> None:
    for module in pkgutil.walk_packages(planning.__path__, "planning."):
        if not module.name.endswith("_native"):
            importlib.import_module(module.name)
    ours = {kind for kind in values_of(Value) if kind.__module__.startswith("planning.")}
    assert len(ours) > 50
    counts = Counter(kind.__qualname__ for kind in ours)
    assert not [name for name, count in counts.items() if count > 1]
