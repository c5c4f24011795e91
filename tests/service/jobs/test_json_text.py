"""Texts give back what went in, bit for bit, or null where JSON has no number."""

import json
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from service.jobs.json_text import (
    Encoded,
    decode_parts,
    encode,
    encode_in_parts,
    encode_leniently,
)
from tests.profiles import num_cases

SCALARS = st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats() | st.text()
CONTENT = st.recursive(
    SCALARS, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20
)


def expected(content):
    match content:
        case float() if not math.isfinite(content):
            return None
        case dict():
            return {key: expected(item) for key, item in content.items()}
        case list():
            return [expected(item) for item in content]
        case _:
            return content


@given(CONTENT)
def test_what_goes_in_comes_out(content):
    text = encode(content)
    assert text.isascii()
    assert "\0" not in text
    assert repr(json.loads(text)) == repr(expected(content))


ODD = [np.int64(1), np.zeros(2), object(), {1}, b""]


@pytest.mark.parametrize("odd", ODD)
def test_what_only_python_knows_is_refused(odd):
    with pytest.raises(TypeError):
        encode({"a": [odd]})


def test_what_is_no_json_is_refused_or_shown():
    with pytest.raises(TypeError):
        encode({"a": {1, 2}})
    assert json.loads(encode_leniently({"a": {1}})) == {"shown": "{'a': {1}}"}
    endless = []
    endless.append(endless)
    with pytest.raises(ValueError, match="Circular"):
        encode(endless)
    assert "shown" in json.loads(encode_leniently(endless))


@given(
    plain=st.dictionaries(st.text(), CONTENT.map(expected), min_size=1, max_size=3),
    encoded=st.dictionaries(st.text(), CONTENT.map(expected), max_size=3),
)
@settings(max_examples=num_cases(20))
def test_parts_are_taken_apart_as_they_were_put_together(plain, encoded):
    assume(not plain.keys() & encoded.keys())
    parts = {name: Encoded(encode(part)) for name, part in encoded.items()}
    text = encode_in_parts({**parts, **plain})
    assert decode_parts(text) == {**plain, **parts}
    assert json.loads(text) == {**plain, **encoded}
