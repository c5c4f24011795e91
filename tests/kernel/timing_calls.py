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
        "time_path": call(
            partial(with_path, module.time_path), breaks=(np.array([0.0, 1.0]), EXACT),
            coefficients=(np.array([[[0.0, 0.0], [1.0, 0.5], [0.1, 0.0]]]), ANY),
            velocity=(np.ones(2), EXACT), acceleration=(np.ones(2), EXACT),
        ),
        "squared_speeds": call(
            module.squared_speeds, edges=(np.linspace(0.0, 1.0, 3), SIZING),
            a=(np.array([[1.0, -1.0], [0.5, -0.5]]), EXACT), b=(np.zeros((2, 2)), EXACT),
            caps=(np.ones(3), EXACT),
        ),
        "speed_cells": call(
            partial(with_path, module.speed_cells), breaks=(np.array([0.0, 0.5, 1.0]), SIZING),
            coefficients=(np.ones((2, 3, 2)), ANY), limits=(np.ones((3, 2)), ANY), count=(16, ANY),
            least=(2, ANY),
        ),
        "corners": call(
            partial(with_path, module.corners), breaks=(np.array([0.0, 0.5, 1.0]), SIZING),
            coefficients=(np.ones((2, 3, 2)), ANY), smoothness=(2, ANY),
        ),
        "duration_bound": call(
            partial(with_path, module.duration_bound), breaks=(np.array([0.0, 0.5, 1.0]), SIZING),
            coefficients=(np.ones((2, 3, 2)), ANY), bases=(np.zeros((2, 2)), EXACT),
            limits=(np.ones((3, 2)), ANY), smoothness=(1, ANY),
        ),
        "blend": call(
            module.blend, waypoints=(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), ANY),
            deviation=(0.1, ANY), has_smooth_curvature=(True, ANY),
        ),
        "box_visits": call(
            module.box_visits, breaks=(np.array([0.0, 1.0]), EXACT),
            points=(np.ones((1, 2, 3)), ANY), half=(np.ones(3), EXACT), halvings=(2, ANY),
        ),
        "profile_between": call(
            module.profile_between, edges=(np.linspace(0.0, 1.0, 4), EXACT),
            x=(np.array([0.0, 0.5, 0.5, 0.0]), EXACT), is_line=(np.array([True, False, True]), ANY),
            speed=(np.ones(3), EXACT), acceleration=(np.ones(3), EXACT),
            braking=(np.ones(3), EXACT),
        ),
        "compose": call(
            partial(with_path, module.compose), breaks=(np.array([0.0, 1.0]), EXACT),
            coefficients=(np.array([[[0.0, 0.0], [1.0, 0.5], [0.1, 0.0]]]), ANY),
            s=(np.array([0.0, 1.0]), EXACT), v=(np.ones(1), EXACT), a=(np.zeros(1), EXACT),
            j=(np.zeros(1), EXACT), h=(np.ones(1), SIZING),
        ),
        "utilization": call(
            module.utilization, coefficients=(np.ones((2, 3, 2)), ANY),
            widths=(np.ones(2), EXACT), limits=(np.ones(2), EXACT), order=(1, ANY),
        ),
    }  # fmt: skip


def with_path(function: Callable[..., Any], **given: Any) -> Any:
    path = tuple(given.pop(name) for name in ("breaks", "coefficients"))
    return function(path=path, **given)


def with_profile(function: Callable[..., Any], **given: Any) -> Any:
    path = tuple(given.pop(name) for name in ("breaks", "coefficients"))
    profile = tuple(given.pop(name) for name in "svajh")
    phases = tuple(given.pop(name) for name in ("durations", "parameters"))
    return function(path=path, profile=profile, phases=phases, **given)
