"""Durations: how long questions took lately, from which is known which ones are short."""

import math
from collections import OrderedDict
from dataclasses import dataclass

# What takes no longer may have the worker that is kept for what is short [s].
SHORT = 0.5
# So many scenes and kinds of questions to them are remembered.
_MOST = 4096


@dataclass(frozen=True)
class CallKind:
    """What questions that take about as long have in common.

    Attributes:
        task: Their task.
        size: How much is asked, in powers of two.
        is_load: Whether a scene is loaded anew, even where one is loaded already.
    """

    task: str
    size: int = 0
    is_load: bool = False


class DurationHistory:
    """Remembers the last duration of questions by kind and scene, and of loading a scene."""

    def __init__(self) -> None:
        """Remember nothing yet."""
        self._runs: OrderedDict[tuple[CallKind, str | None], float] = OrderedDict()
        self._loads: OrderedDict[str | None, float] = OrderedDict()

    def is_short(self, kind: CallKind, key: str | None, *, is_warm: bool) -> bool:
        """Return whether a question is likely to be short.

        A scene that was not loaded yet may take minutes; a question to a loaded one that was
        not asked yet is likely to be short.

        Args:
            kind: Of the question.
            key: Of its scene, or None.
            is_warm: Whether the scene is loaded where the question would be answered.
        """
        load = self._loads.get(key, math.inf)
        known = self._runs.get((kind, key))
        if kind.is_load:
            expected = load if known is None else known
        elif is_warm or key is None:
            expected = known or 0.0
        else:
            expected = load + (known or 0.0)
        return expected <= SHORT

    def record_run(
        self, kind: CallKind, key: str | None, seconds: float, *, was_warm: bool
    ) -> None:
        """Remember how long a question took, with the load of its scene if that was not warm."""
        if kind.is_load or was_warm or key is None:
            _put(self._runs, (kind, key), seconds)
        else:
            _put(self._loads, key, seconds)

    def record_load(self, key: str, seconds: float) -> None:
        """Remember how long a scene took to load."""
        _put(self._loads, key, seconds)


def _put[K](found: OrderedDict[K, float], key: K, seconds: float) -> None:
    found[key] = seconds
    found.move_to_end(key)
    if len(found) > _MOST:
        found.popitem(last=False)
