"""read_yaml(): strict YAML without aliases, repeated keys or keys other than text."""

from typing import Any

import yaml

MAX_EVENTS = 500_000
MAX_DEPTH = 64
_TEXT = "tag:yaml.org,2002:str"


def read_yaml(text: str | bytes) -> tuple[Any, Any]:
    """Return the content of a YAML text, and its tree of nodes, which have their lines.

    Raises:
        yaml.YAMLError: It is not YAML, or uses what is refused; the message has the line.
    """
    try:
        _validate_events(text)
        node: Any = yaml.compose(text, Loader=yaml.CSafeLoader)
        _validate_unique_keys(node)
        return yaml.load(text, Loader=yaml.CSafeLoader), node
    # Errors of PyYAML's scalar constructors for words that do not match their tag.
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as fault:
        message = f"a value is not of its tag: {str(fault)[:200]}"
        raise yaml.YAMLError(message) from fault
    except RecursionError as fault:
        message = f"nested more than {MAX_DEPTH} deep"
        raise yaml.YAMLError(message) from fault


def _validate_events(text: str | bytes) -> None:
    """Raise on aliases and deep nesting, by a pass over the events that builds nothing."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=yaml.CSafeLoader)):
        if isinstance(event, yaml.AliasEvent):
            raise yaml.YAMLError(_at("aliases are not allowed", event.start_mark))
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if count > MAX_EVENTS or depth > MAX_DEPTH:
            limits = f"at most {MAX_EVENTS} values, nested at most {MAX_DEPTH} deep"
            raise yaml.YAMLError(_at(f"too large: {limits}", event.start_mark))


def _validate_unique_keys(node: Any) -> None:
    """Raise on a repeated key: YAML would silently keep the last one."""
    pending = [node]
    while pending:
        current = pending.pop()
        if isinstance(current, yaml.MappingNode):
            seen: set[str] = set()
            for key, child in current.value:
                _validate_key(key)
                if key.value in seen:
                    raise yaml.YAMLError(_at(f"key {key.value!r} is given twice", key.start_mark))
                seen.add(str(key.value))
                pending.append(child)
        elif isinstance(current, yaml.SequenceNode):
            pending += current.value


def _validate_key(key: Any) -> None:
    """Raise on a key that is not text."""
    if isinstance(key, yaml.ScalarNode):
        if key.tag != _TEXT:
            problem = f"the key {key.value!r} is not text: put it in quotes if it is meant as text"
            raise yaml.YAMLError(_at(problem, key.start_mark))
        return
    kind = "mapping" if isinstance(key, yaml.MappingNode) else "list"
    problem = f"a key must be text, got a {kind}"
    if isinstance(key, yaml.MappingNode):
        problem += "; `{{ ... }}` is a template that was not filled in, or needs quotes"
    raise yaml.YAMLError(_at(problem, key.start_mark))


def _at(problem: str, mark: Any) -> str:
    return f"line {mark.line + 1}: {problem}"
