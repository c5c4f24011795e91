"""Valid calls of what proofs and refinement know of loads in the native module."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tests.kernel.call_rules import EXACT, INDEX, INDICES, KIND, OBJECT, SCALAR, SIZING, Call, call

X = np.array([1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0, 0, 0, 0.3])
Z, MASS = np.array([0.0, 0.0, 1.0]), np.array([2.0, *np.full(6, 0.1), *X[:9]])
GRAVITY = np.array([0.0, 0.0, -9.81])


def load_calls(module: Any) -> dict[str, Call]:
    """Return them by name."""
    torques = module.TorqueSeries(2, 2, GRAVITY)
    kinds = module.JointKind
    add_link = call(
        partial(with_pairs, torques.add_link), parent=(0, INDEX), X_PF=(X, EXACT),
        kind=(kinds.PRISMATIC, KIND), axis=(Z, EXACT), position=(1, INDEX), velocity=(1, INDEX),
        scale=(1.0, SCALAR), offset=(0.1, SCALAR), damping=(0.1, SCALAR),
        rotor_inertia=(0.1, SCALAR), mass=(MASS, EXACT),
    )  # fmt: skip
    add_link(parent=-1, kind=kinds.REVOLUTE, position=0, velocity=0)
    return {
        "TorqueSeries": call(
            module.TorqueSeries, num_positions=(2, INDEX), num_velocities=(2, INDEX),
            gravity=(GRAVITY, EXACT),
        ),
        "TorqueSeries.add_link": add_link,
        "TorqueSeries.polynomials": call(
            torques.polynomials, bases=(np.zeros((2, 2)), SIZING),
            coefficients=(np.ones((2, 4, 2)), EXACT), pieces=(np.array([0, 1, 1]), INDICES),
            middles=(np.full(3, 0.1), EXACT), halves=(np.full(3, 0.1), EXACT), order=(2, INDEX),
            kernel=("base", OBJECT),
        ),
        "TorqueSeries.points": call(
            torques.points, bases=(np.zeros((2, 2)), SIZING),
            coefficients=(np.ones((2, 4, 2)), EXACT), pieces=(np.array([0, 1, 1]), INDICES),
            middles=(np.full(3, 0.1), EXACT), point=(Z, EXACT), kernel=("base", OBJECT),
        ),
        "load_rows": call(
            partial(with_instants, module.load_rows), first_points=(np.array([0, 1, 1]), INDICES),
            intervals=(np.array([0, 1, 1]), INDICES), fractions=(np.array([0, 0.5, 1]), EXACT),
            ends=(np.ones((3, 2)), EXACT), rates=(np.ones((2, 3, 2)), EXACT),
            weights=(np.ones((3, 3, 4)), EXACT), step=(0.5, SCALAR),
            ratios=(np.ones((3, 1, 3)), EXACT), derivatives=(np.ones((3, 3, 1, 3, 2)), EXACT),
            point_columns=(np.arange(-2, 8).clip(-1).reshape(5, 2), OBJECT),
            velocity_columns=(np.array([-1, 8, -1]), OBJECT), radii=(np.ones(2), EXACT),
            bound=(1.0, SCALAR), price=(1.0, SCALAR), is_static=(False, OBJECT),
            is_one_sided=(False, OBJECT),
        ),
    }  # fmt: skip


def with_instants(function: Callable[..., Any], **given: Any) -> Any:
    names = ("first_points", "intervals", "fractions", "ends", "rates", "weights", "step")
    layout = tuple(given.pop(name) for name in ("point_columns", "velocity_columns"))
    return function(instants=tuple(given.pop(name) for name in names), layout=layout, **given)


def with_pairs(function: Callable[..., Any], **given: Any) -> Any:
    coordinate = tuple(given.pop(name) for name in ("position", "velocity", "scale", "offset"))
    drive = tuple(given.pop(name) for name in ("damping", "rotor_inertia"))
    return function(coordinate=coordinate, drive=drive, **given)
