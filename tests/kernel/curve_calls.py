"""Valid calls of what moves curves in the native module."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from planning.refine.curves.path_velocity import path_grid
from planning.refine.model.variable_layout import make_variable_layout
from tests.kernel.call_rules import ANY, EXACT, INDICES, OBJECT, SCALAR, SIZING, Call, call

COUNT, SIZE = 6, 2
GRID, LAYOUT = path_grid(COUNT), make_variable_layout(COUNT, SIZE)
POINTS = np.linspace(0.0, 1.0, COUNT)[:, None] ** [1, 2]
NUM_INTERVALS = len(GRID.control_points)
B = np.concatenate([[0.0], np.full(NUM_INTERVALS - 1, 0.5), [0.0]])
RANGE = np.stack([-np.ones(SIZE), np.ones(SIZE)])
WEIGHTS = np.array([1e-4, 0.7, 1.5, 0.3, 0.4, 10.0, 1e-6])


def grid_arguments() -> dict[str, Any]:
    return {
        "first_points": GRID.control_points[:, 0].astype(np.int64),
        "num_points": COUNT,
        "first": GRID.first,
        "second": GRID.second,
        "third": GRID.third,
        "step": GRID.step,
    }


def curve_calls(module: Any) -> dict[str, Call]:
    """Return them by name."""
    ones, given = np.ones(SIZE), grid_arguments()
    grid = module.CurveGrid(**given)
    bounds = {
        "velocity": (ones, SIZING), "acceleration": (ones, EXACT), "jerk": (ones, ANY),
        "acceleration_range": (RANGE, EXACT),
    }  # fmt: skip
    return {
        "spline_weights": call(
            module.spline_weights, num_points=(COUNT, ANY), s=(np.array([0.0, 0.3, 1.0]), ANY)
        ),
        "spline_positions": call(
            module.spline_positions, points=(POINTS, ANY), num_intervals=(7, ANY)
        ),
        "CurveGrid": call(
            module.CurveGrid, first_points=(given["first_points"], INDICES),
            num_points=(COUNT, ANY), first=(GRID.first, EXACT), second=(GRID.second, EXACT),
            third=(GRID.third, EXACT), step=(GRID.step, SCALAR),
        ),
        "CurveGrid.path_velocity": call(
            partial(with_bounds, grid.path_velocity), **bounds, points=(POINTS, EXACT),
            low=(np.zeros((NUM_INTERVALS, 3)), SIZING), high=(np.ones((NUM_INTERVALS, 3)), EXACT),
            tolerance=(1e-6, ANY), max_steps=(20, ANY),
        ),
        "CurveGrid.step": call(
            partial(with_program, grid.step), **bounds, points=(POINTS, EXACT),
            path_velocity=(B, EXACT),
            point_columns=(LAYOUT.control_points.astype(np.int64), OBJECT),
            velocity_columns=(LAYOUT.path_velocity.astype(np.int64), OBJECT),
            num_variables=(LAYOUT.num_variables, ANY), model_weights=(WEIGHTS, EXACT),
            radii=(ones, EXACT), lower=(-ones, EXACT), upper=(2 * ones, EXACT),
            starts=(np.array([0, 1]), OBJECT), columns=(np.array([0]), INDICES),
            values=(np.ones(1), EXACT), least=(np.zeros(1), SIZING), price=(np.ones(1), EXACT),
            ball_starts=(np.array([0, 2]), OBJECT), ball_columns=(np.array([0, 1]), INDICES),
            ball_values=(np.ones(6), EXACT), ball_centers=(np.zeros(3), EXACT),
            ball_prices=(np.ones(1), EXACT),
            sample_points=(np.array([0, 2]), INDICES), weights=(np.full((2, 4), 0.25), EXACT),
            sample_indices=(np.array([0, 1, 1]), INDICES), margins=(np.full(3, 0.01), EXACT),
            gradients=(np.ones((3, SIZE)), EXACT), price_per_metre=(1.0, SCALAR),
            tolerance=(1e-6, ANY), max_steps=(20, ANY),
        ),
    }  # fmt: skip


def with_bounds(function: Callable[..., Any], **given: Any) -> Any:
    names = ("velocity", "acceleration", "jerk", "acceleration_range")
    return function(bounds=tuple(given.pop(name) for name in names), **given)


def with_program(function: Callable[..., Any], **given: Any) -> Any:
    groups = {
        "layout": ("point_columns", "velocity_columns", "num_variables"),
        "box": ("radii", "lower", "upper"),
        "rows": ("starts", "columns", "values", "least", "price"),
        "balls": (
            "ball_starts", "ball_columns", "ball_values", "ball_centers", "ball_prices",
        ),
        "margins": (
            "sample_points", "weights", "sample_indices", "margins", "gradients", "price_per_metre",
        ),
    }  # fmt: skip
    tuples = {group: tuple(given.pop(name) for name in names) for group, names in groups.items()}
    return with_bounds(function, **tuples, **given)
