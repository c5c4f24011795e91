"""docs/explanation/tolerances.md lists every tolerance of `planning`, as the code has it.

`python -m tests.conventions.test_tolerances` writes the page anew.
"""

import ast
import tokenize
from collections.abc import Iterator
from io import StringIO
from pathlib import Path

PAGE = Path("docs/explanation/tolerances.md")
# Constants up to this are tolerances: rounding errors, gaps of bounds, steps of differences.
_LARGEST = 5e-3
_HEAD = """# Tolerances

Every number of `planning` up to 0.005 that decides where exact arithmetic would need none:
rounding errors, gaps of bounds, steps of differences, smallest lengths. Each stands beside its
only use, with its unit and reason as a comment: a number in a table far away would be changed
without reading what it protects. This page is made from those comments, and a test keeps it so.
"""


def _comments(source: str) -> dict[int, str]:
    """Return the comment of each line that has nothing else."""
    tokens = tokenize.generate_tokens(StringIO(source).readline)
    return {
        token.start[0]: token.string.removeprefix("#").strip()
        for token in tokens
        if token.type == tokenize.COMMENT and not token.line[: token.start[1]].strip()
    }


def tolerances(source: str) -> Iterator[tuple[str, float, str]]:
    """Yield name, value and meaning of each tolerance that a module defines."""
    comments, above, last = _comments(source), "", 0
    for node in ast.parse(source).body:
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
            continue
        line, lines = node.lineno - 1, list[str]()
        while line in comments:
            lines.insert(0, comments[line])
            line -= 1
        # Constants that follow one another share the comment above the first.
        above = " ".join(lines) or (above if node.lineno == last + 1 else "")
        last = node.end_lineno or node.lineno
        value = node.value
        number = value.value if isinstance(value, ast.Constant) else None
        if isinstance(number, float) and 0 < number <= _LARGEST:
            yield node.targets[0].id, number, above


def page() -> str:
    """Return the page: a table for each package."""
    parts = [_HEAD]
    for package in sorted(path for path in Path("planning").iterdir() if path.is_dir()):
        rows = [
            f"| `{file.relative_to(package)}` | `{name}` | {value:g} | {meaning} |"
            for file in sorted(package.rglob("*.py"))
            for name, value, meaning in tolerances(file.read_text(encoding="utf-8"))
        ]
        if rows:
            head = [
                f"\n## {package.name}\n",
                "| file | name | value | meaning |",
                "|---|---|---|---|",
            ]
            parts.append("\n".join([*head, *rows]) + "\n")
    return "".join(parts)


def test_the_page_has_every_tolerance_as_the_code_has_it() -> None:
    message = "run `python -m tests.conventions.test_tolerances`"
    assert PAGE.read_text(encoding="utf-8") == page(), message


def test_every_tolerance_says_what_it_is() -> None:
    unsaid = [row for row in page().splitlines() if row.startswith("| `") and row.endswith("|  |")]
    assert unsaid == []


def test_comments_above_constants_are_their_meaning() -> None:
    source = "# Gap of a bound\n# [m].\n_GAP = 1e-9\n_TINY = 1e-12\n\n_LARGE = 1.0\n_BARE = 1e-3\n"
    found = list(tolerances(source))
    assert found == [
        ("_GAP", 1e-9, "Gap of a bound [m]."),
        ("_TINY", 1e-12, "Gap of a bound [m]."),
        ("_BARE", 1e-3, ""),
    ]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
