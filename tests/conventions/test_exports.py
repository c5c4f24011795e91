"""The doors are real, sorted, and open only what they need."""

import subprocess
import sys

import pytest

import planning


@pytest.mark.parametrize("name", planning.__all__)
def test_every_door_opens(name: str) -> None:
    assert getattr(planning, name).__name__ == name


def test_doors_are_sorted_and_listed_once() -> None:
    assert planning.__all__ == sorted(set(planning.__all__))
    assert sorted(planning._DOORS) == planning.__all__


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
