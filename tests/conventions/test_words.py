"""Words that the code once had in place of the field's may not come back in names."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

# Word that is refused -> the field's word, by which a stranger finds the code.
WORDS = {
    "felt": "load evaluation",
    "strain": "load linearization",
    "wish": "objective, preferred margin",
    "wishes": "objectives",
    "aims": "target samples",
    "aiming": "target selection",
    "letters": "arc segments",
    "haste": "duration gradient",
    "pace": "path velocity",
    "shelf": "cache",
    "gardener": "region growth",
    "audience": "coverage samples",
    "crowd": "clique samples",
    "sighting": "closest approach",
    "spot": "witness point",
    "nearness": "distance query",
    "judge": "checker, check",
    "course": "trace state, path",
    "halt": "stop",
    "leg": "linear move",
    "dust": "rounding",
    "burden": "payload",
    "stretch": "piece",
    "hop": "speed segment",
    "ruled": "constrained",
    "rules": "path constraints",
    "spare": "signed margin",
    "demand": "threshold",
    "told": "the value's own noun",
    "asked": "requested",
    "looks": "num_segments, evaluations",
    "leash": "parent watch",
    "manager": "the noun of what it does",
    "handler": "the noun of what it does",
    "utils": "the noun of what it does",
    "helpers": "the noun of what it does",
    "misc": "the noun of what it does",
}
SOURCES = sorted(Path("planning").rglob("*.py"))


def _words(name: str) -> set[str]:
    parts = re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)
    words = {part.lower() for part in parts}
    return words | {word.removesuffix("s") for word in words}


def names_of(source: str) -> Iterator[tuple[int, str]]:
    """Yield the line and the name of what a module defines: not what libraries call theirs."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


def refused(source: str) -> list[str]:
    """Return what is wrong with the names of a module, and which words are right."""
    return [
        f"line {line}: {name!r} has {word!r}: {WORDS[word]}"
        for line, name in names_of(source)
        for word in sorted(_words(name) & set(WORDS))
    ]


def test_names_have_the_words_of_the_field() -> None:
    wrong = {str(file): refused(file.read_text(encoding="utf-8")) for file in SOURCES}
    assert {file: lines for file, lines in wrong.items() if lines} == {}
    assert [file for file in SOURCES if _words(file.stem) & set(WORDS)] == []


def test_old_words_are_refused_wherever_they_are_defined() -> None:
    source = "class Felt:\n    def by_pace(self, num_letters):\n        self.wishes = aims = 1\n"
    assert len(refused(source)) == 5
    assert refused("path_velocity = told.felt(judge=1)\nspacecraft, rulers = 1, 2\n") == []
