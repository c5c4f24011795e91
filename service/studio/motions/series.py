"""Series: what a motion does and uses over time, as the server has it."""

from dataclasses import dataclass

import numpy as np
from pydantic import ConfigDict

from service.client.models import Answer
from service.studio.numbers import Array
from service.studio.texts import short

# Below it no limit binds.
_BINDING = 0.98


class Bounds(Answer):
    """Of a quantity, per coordinate."""

    lower: list[float | None]
    upper: list[float | None]


class SeriesAnswer(Answer):
    """The server's answer."""

    model_config = ConfigDict(extra="ignore")

    times: list[float]
    position_names: list[str]
    velocity_names: list[str]
    positions: list[list[float]]
    velocities: list[list[float]]
    accelerations: list[list[float]]
    jerks: list[list[float]]
    torques: list[list[float]]
    limits: dict[str, Bounds]
    tool_speeds: dict[str, list[float]]
    utilisation: dict[str, list[float]]


@dataclass(frozen=True)
class Curves:
    """Curves over the instants of a series.

    Attributes:
        names: Of the curves.
        rows: Their values, finite, shape (n, curves).
    """

    names: list[str]
    rows: Array


class Series:
    """A motion over time."""

    def __init__(self, answer: SeriesAnswer) -> None:
        """Read an answer."""
        self.times: Array = np.array(answer.times)
        q = [short(name) for name in answer.position_names]
        v = [short(name) for name in answer.velocity_names]
        self.curves = {
            "position": Curves(q, np.array(answer.positions)),
            "velocity": Curves(v, np.array(answer.velocities)),
            "acceleration": Curves(v, np.array(answer.accelerations)),
            "jerk": Curves(v, np.array(answer.jerks)),
            "torque": Curves(v, np.array(answer.torques)),
            "utilisation": _table(answer.utilisation, 100.0, " [%]"),
        }
        if answer.tool_speeds:
            self.curves["tool speed"] = _table(answer.tool_speeds, 1.0, " [m/s]")
        # Torque counts only where the plan was to keep it, and nothing here says whether it was.
        self._used = {name: row for name, row in answer.utilisation.items() if name != "torque"}

    @property
    def limit_names(self) -> list[str]:
        """Names of the limits, as their checks have them."""
        return list(self._used)

    def binding(self) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], Array]:
        """Return which limit is used most at each instant, and its share, both shape (n,).

        The first are indices into `limit_names`, or -1 where no limit binds.
        """
        shares = np.array(list(self._used.values())).reshape(len(self._used), len(self.times))
        if not len(shares):
            return np.full(len(self.times), -1), np.zeros(len(self.times))
        most = shares.max(axis=0)
        return np.where(most < _BINDING, -1, shares.argmax(axis=0)), most


def _table(rows: dict[str, list[float]], factor: float, unit: str) -> Curves:
    names = [" ".join(map(short, name.split(" "))) + unit for name in rows]
    return Curves(names, factor * np.array(list(rows.values())).T)
