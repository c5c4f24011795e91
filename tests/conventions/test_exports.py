"""The doors are real, sorted, and open only what they need."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import planning


@pytest.mark.parametrize("name", planning.__all__)
def test_every_door_opens(name: str) -> None:
    assert getattr(planning, name).__name__ == name


def test_doors_are_sorted_and_listed_once() -> None:
    assert planning.__all__ == sorted(set(planning.__all__))


def test_type_checkers_see_every_door() -> None:
    """What they see stands apart: modules that nothing imports when the program runs."""
    tree = ast.parse(Path(planning.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {alias.name: statement.module for statement in block.body for alias in statement.names}
    assert sorted(seen) == planning.__all__
    found = {name: getattr(planning, name) for name in seen}
    assert {name: getattr(import_module(where), name) for name, where in seen.items()} == found


def test_importing_planning_loads_no_engine() -> None:
    code = (
        "import sys, planning, planning.errors\n"
        "print([m for m in ('pydrake', 'ompl', 'toppra', 'ruckig', 'numpy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_what_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'plann'"):
        planning.plann  # noqa: B018
