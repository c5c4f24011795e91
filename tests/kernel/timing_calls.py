"""Valid calls of what times paths in the native module."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tests.kernel.call_rules import ANY, EXACT, SIZING, Call, call


def timing_calls(module: Any) -> dict[str, Call]:
    """Return them by name."""
    return {
        "optimize_profile": call(
            partial(with_profile, module.optimize_profile), breaks=(np.array([0.0, 1.0]), EXACT),
            coefficients=(np.array([[[0.0, 0.0], [1.0, 0.5], [0.1, 0.0], [0.0, 0.2]]]), ANY),
            s=(np.array([0.0, 1.0]), EXACT), v=(np.ones(1), EXACT), a=(np.zeros(1), EXACT),
            j=(np.zeros(1), EXACT), h=(np.ones(1), SIZING), durations=(np.ones(5), EXACT),
            parameters=(np.linspace(0.0, 1.0, 6), SIZING), limits=(np.ones((3, 2)), EXACT),
        ),
        "fastest_chain": call(
            module.fastest_chain, positions=(np.linspace(0.0, 1.0, 4), SIZING),
            peaks=(np.ones((6, 3, 2)), ANY), speeds=(np.full((4, 2), 0.1), ANY),
            jerk_shares=(np.array([0.5]), ANY), most_intervals=(3, ANY),
        ),
    }  # fmt: skip


def with_profile(function: Callable[..., Any], **given: Any) -> Any:
    path = tuple(given.pop(name) for name in ("breaks", "coefficients"))
    profile = tuple(given.pop(name) for name in "svajh")
    phases = tuple(given.pop(name) for name in ("durations", "parameters"))
    return function(path=path, profile=profile, phases=phases, **given)
