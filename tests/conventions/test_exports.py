"""The public names of `planning` exist, and importing the package loads no engine."""

import subprocess
import sys

import pytest

import planning


@pytest.mark.parametrize("name", planning.__all__)
def test_every_public_name_is_that_of_what_it_names(name: str) -> None:
    assert getattr(planning, name).__name__ == name


def test_public_names_are_sorted_and_no_more_than_a_page() -> None:
    assert planning.__all__ == sorted(set(planning.__all__)) == dir(planning)
    assert 50 < len(planning.__all__) < 85


def test_importing_planning_loads_no_engine() -> None:
    code = (
        "import sys, planning, planning.errors\n"
        "print([m for m in ('pydrake', 'ompl', 'toppra', 'ruckig', 'numpy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_what_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="No planning attribute plann"):
        planning.plann  # noqa: B018
