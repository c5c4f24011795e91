"""Large JSON is decoded as small JSON is, and never much of it at once."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.jobs import json_steps
from service.jobs.json_steps import decode, member_of, members_of
from service.jobs.json_text import Encoded, encode, encode_in_parts

TEXTS = st.text(st.sampled_from('ab\\"[]{},: é\n'), max_size=8)
CONTENT = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXTS,
    lambda inner: st.dictionaries(TEXTS, inner) | st.lists(inner) | st.lists(st.integers()),
    max_leaves=40,
)
MANY = [[0.1 * i for i in range(7)] for _ in range(300)]
STEP = 500


@pytest.fixture(autouse=True, scope="module")
def small_steps():
    """As if what is here were large."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(json_steps, "STEP", 3)
        yield


@given(CONTENT)
def test_it_says_what_json_says(content):
    text = encode(content)
    assert decode(text) == json.loads(text)


@given(st.dictionaries(TEXTS, CONTENT))
def test_members_are_the_texts_of_members(content):
    found = dict(members_of(encode(content)))
    assert {name: json.loads(part) for name, part in found.items()} == content
    for name in content:
        assert member_of(encode(content), name) == found[name]
    assert member_of(encode(content), "never there") is None


@given(
    plain=st.dictionaries(TEXTS, CONTENT, min_size=1, max_size=3),
    large=st.dictionaries(TEXTS, CONTENT, max_size=3),
)
def test_members_that_have_lines_of_their_own_are_found_as_others_are(plain, large):
    plain = {name: part for name, part in plain.items() if name not in large} or {"": 0}
    large.pop("", None)
    parts = {name: Encoded(encode(part)) for name, part in large.items()}
    text = encode_in_parts({**plain, **parts})
    content = {**plain, **large}
    assert decode(text) == content
    assert {name: json.loads(part) for name, part in members_of(text)} == content
    for name, part in content.items():
        assert member_of(text, name) == encode(part)
    assert member_of(text, "never there") is None


@pytest.mark.parametrize(
    "content",
    [
        {"result": {"positions": MANY, "times": [float(i) for i in range(3000)]}, "digest": "d"},
        [{"faces": MANY[:3], "name": '"]'} for _ in range(100)],
        {"strings": ["x" * 20] * 500},
    ],
)
def test_never_much_is_decoded_at_once(monkeypatch, content):
    text, decoded = encode(content), []
    assert len(text) > 10 * STEP

    def loads(part):
        decoded.append(len(part))
        return json.JSONDecoder().decode(part)

    monkeypatch.setattr(json_steps, "STEP", STEP)
    monkeypatch.setattr(json_steps.json, "loads", loads)
    assert decode(text) == content
    assert max(decoded) < 2 * STEP
