"""Texts give back what went in, bit for bit, or null where JSON has no number."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs.json_text import encode, encode_leniently

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


def test_what_is_no_json_is_refused_or_shown():
    with pytest.raises(TypeError):
        encode({"a": {1, 2}})
    assert json.loads(encode_leniently({"a": {1}})) == {"shown": "{'a': {1}}"}
    endless = []
    endless.append(endless)
    with pytest.raises(ValueError, match="Circular"):
        encode(endless)
    assert "shown" in json.loads(encode_leniently(endless))
