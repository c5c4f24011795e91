"""Jitter: how late the ticks of an execution were, as a few numbers of any number of ticks."""

import math

from service.executions.models import Jitter

# Bins of delays: the first is up to _LEAST [s], each next one reaches _RATIO times as far.
_LEAST, _RATIO, _COUNT = 1e-6, 1.05, 400


class JitterLog:
    """Counts delays in bins, each 5 % wider than the one before; the largest is exact."""

    def __init__(self) -> None:
        """Begin without a tick."""
        self._counts = [0] * _COUNT
        self._ticks = 0
        self._largest = 0.0

    def note(self, delay: float) -> None:
        """Note how much later than it was due a tick came [s]; not at all if negative."""
        late = max(0.0, delay)
        bin_index = 0 if late <= _LEAST else math.ceil(math.log(late / _LEAST) / math.log(_RATIO))
        self._counts[min(bin_index, _COUNT - 1)] += 1
        self._ticks += 1
        self._largest = max(self._largest, late)

    @property
    def jitter(self) -> Jitter:
        """Median, 99th percentile (both at most 5 % too large) and largest delay."""
        return Jitter(
            ticks=self._ticks,
            median=self._quantile(0.5),
            p99=self._quantile(0.99),
            max=self._largest,
        )

    def _quantile(self, share: float) -> float:
        rank, passed = share * self._ticks, 0
        for i, count in enumerate(self._counts):
            passed += count
            if passed >= rank:
                return min(_LEAST * _RATIO**i, self._largest)
        return self._largest
