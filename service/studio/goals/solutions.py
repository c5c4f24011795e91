"""Solutions: configurations that reach a goal, ranked, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from service.studio.numbers import Array
from service.studio.texts import millimetres

_SIGNS = {1: "+", -1: "−", 0: "0"}  # noqa: RUF001


class Solutions:
    """What inverse kinematics found for a goal, nearest first."""

    def __init__(self, configurations: Sequence[Mapping[str, Any]]) -> None:
        """Read configurations as the API gives them, at least one."""
        self._found = {
            _words(i + 1, configuration): configuration
            for i, configuration in enumerate(configurations)
        }

    @property
    def names(self) -> tuple[str, ...]:
        """What they are called, the nearest first."""
        return tuple(self._found)

    def positions(self, name: str) -> Array:
        """Return a configuration by its name [rad or m], shape (nq,)."""
        return np.array(self._found[name]["positions"])

    def others(self, name: str, most: int) -> list[Array]:
        """Return configurations that look different from one and from each other, nearest first.

        Args:
            name: Of the one.
            most: How many at most.
        """
        seen, found = [self.positions(name)], list[Array]()
        for other in self._found:
            positions = self.positions(other)
            # Whole turns apart they look the same.
            if all(np.abs(np.exp(1j * positions) - np.exp(1j * q)).max() > 1e-3 for q in seen):
                seen.append(positions)
                found.append(positions)
        return found[:most]


def _words(rank: int, configuration: Mapping[str, Any]) -> str:
    gap, branch = configuration["clearance"], configuration.get("branch") or {}
    # Short, for the page cuts what does not fit.
    parts = ["" if gap is None else millimetres(gap)]
    parts.append(" ".join(f"{name}{_SIGNS[int(sign)]}" for name, sign in branch.items()))
    return f"{rank}. {' · '.join(part for part in parts if part)}"
