"""Values of the schemas of the OpenAPI document, and what they mean once defaults are filled in."""

import json
from pathlib import Path

import jsonschema
from hypothesis import strategies as st

ROOT = Path(__file__).parents[3]
DOCUMENT = json.loads((ROOT / "docs" / "reference" / "openapi.json").read_text())
_WORDS = st.from_regex(r"[a-z]{1,8}", fullmatch=True)


def resolved(schema):
    while "$ref" in schema:
        found = DOCUMENT["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
        schema = {**found, **{key: schema[key] for key in schema if key != "$ref"}}
    return schema


def alternatives(schema):
    """What a schema may be, without null."""
    schema = resolved(schema)
    several = schema.get("anyOf") or schema.get("oneOf")
    if several is None:
        return [schema]
    return [one for each in several for one in alternatives(each) if one.get("type") != "null"]


def values(schema):
    """Values of a schema."""
    options = alternatives(schema)
    return st.one_of([_of(one) for one in options])


def _of(schema):
    options = [schema["const"]] if "const" in schema else schema.get("enum")
    if options is not None:
        return st.sampled_from(options)
    kinds = {"boolean": lambda _: st.booleans(), "string": lambda _: _WORDS}
    kinds |= {"integer": _numbers, "number": _numbers, "array": _lists, "object": _maps}
    return kinds[schema["type"]](schema)


def _numbers(schema):
    low = schema.get("exclusiveMinimum", schema.get("minimum", -1e3))
    high = schema.get("maximum", 1e3)
    if schema["type"] == "integer":
        return st.integers(int(low), int(high))
    # As fine as a page lets one type.
    lowest = max(low, 1e-6) if "exclusiveMinimum" in schema else low
    return st.floats(lowest, high, allow_nan=False)


def _lists(schema):
    fewest = schema.get("minItems", 0)
    most = min(schema.get("maxItems", 3), max(fewest, 2))
    return st.lists(values(schema["items"]), min_size=fewest, max_size=most)


def _maps(schema):
    if "properties" not in schema:
        fewest, inner = schema.get("minProperties", 0), values(schema["additionalProperties"])
        return st.dictionaries(_WORDS, inner, min_size=fewest, max_size=max(fewest, 2))
    required = schema.get("required", ())
    own = {name: values(inner) for name, inner in schema["properties"].items()}
    return st.fixed_dictionaries(
        {name: own[name] for name in required},
        optional={name: value for name, value in own.items() if name not in required},
    )


def completed(value, schema):
    """A value with its defaults, so that two of them mean the same if they are equal."""
    options = alternatives(schema)
    one = next(each for each in options if _fits(value, each))
    if "properties" in one:
        found = {}
        for name, inner in one["properties"].items():
            given_or = value.get(name, inner.get("default"))
            if given_or is None and _is_group(inner):
                given_or = {}
            found[name] = None if given_or is None else completed(given_or, inner)
        return found
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return [completed(each, one["items"]) for each in value]
    return value


def _is_group(schema):
    return "anyOf" not in resolved(schema) and "properties" in resolved(schema)


def _fits(value, schema):
    tag = resolved(schema).get("properties", {}).get("type", {}).get("const")
    if tag is not None:
        return isinstance(value, dict) and value.get("type") == tag
    kinds = {"array": list, "object": dict, "string": str, "boolean": bool}
    expected = kinds.get(schema.get("type"), object)
    return isinstance(value, expected)


def is_valid(value, schema):
    whole = {**schema, "components": DOCUMENT["components"]}
    jsonschema.Draft202012Validator(whole).validate(value)
    return True
