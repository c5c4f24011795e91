"""Quantiles of delays, against numpy's of all delays."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from service.executions.drivers.jitter import JitterLog
from tests.profiles import num_cases


@settings(max_examples=num_cases(20))
@given(st.lists(st.floats(-1.0, 200.0), min_size=1, max_size=300), st.floats(1e-6, 1.0))
def test_quantiles_are_five_percent_too_large_at_most(delays: list[float], scale: float) -> None:
    log = JitterLog()
    for delay in delays:
        log.note(scale * delay)
    late = np.maximum(0.0, scale * np.array(delays))
    found = log.jitter
    assert (found.ticks, found.max) == (len(delays), late.max())
    for value, share in ((found.median, 0.5), (found.p99, 0.99)):
        exact = np.quantile(late, share, method="inverted_cdf")
        assert exact <= value * (1 + 1e-9)
        assert value <= max(1e-6, 1.05 * exact) * (1 + 1e-9)


def test_without_a_tick_nothing_was_late() -> None:
    found = JitterLog().jitter
    assert (found.ticks, found.median, found.p99, found.max) == (0, 0.0, 0.0, 0.0)
