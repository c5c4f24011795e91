"""A valid call of everything that the native module exports, and what its arguments have to be."""

import inspect
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import Any

import numpy as np

from planning.kernel.native import native
from tests.kernel.call_rules import (
    ANY,
    EXACT,
    INDEX,
    INDICES,
    KIND,
    OBJECT,
    ROWS,
    SCALAR,
    SIZING,
    Call,
    call,
)
from tests.kernel.curve_calls import curve_calls
from tests.kernel.load_calls import load_calls
from tests.kernel.shortcut_calls import shortcut_calls
from tests.kernel.timing_calls import timing_calls

IDENTITY = np.array([1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0, 0, 0, 0])
NONE = np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 4)), np.zeros((0, 4)), np.zeros(4)
# Revolute, planar, floating and prismatic, which follows the first.
NQ, NV = 12, 11
STATE = np.array([0.0, 0, 0, 0, 1.0, 0, 0, 0, 0, 0, 2.0, 0.0])


def scene() -> Any:
    """Return a scene of four joints, with a geometry on each link and three that stand."""
    module: Any = native()
    kinds, made = module.JointKind, module.Scene(NQ, NV)
    z = np.array([0.0, 0.0, 1.0])
    for parent, kind, position, velocity in (
        (-1, kinds.REVOLUTE, 0, 0),
        (0, kinds.PLANAR, 1, 1),
        (-1, kinds.FLOATING, 4, 4),
        (1, kinds.PRISMATIC, 11, 10),
    ):
        made.add_link(parent, IDENTITY, kind, z, position, velocity)
    made.add_follower(11, 0, 10, 0, 0.5, 0.1)
    sphere = np.array([[0.0, 0.0, 0.0, 0.1]])
    for link in range(4):
        arguments = _geometry(link) | {"inner": sphere, "X_LG": at(0.5 + 0.5 * link, 0.0)}
        made.add_geometry(**arguments)
    corners = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]) - [3.0, 0.0, 0.0]
    planes = np.array([
        [-1.0, 0, 0, 3],
        [0, -1.0, 0, 0],
        [0, 0, -1.0, 0],
        [*np.full(3, 3**-0.5), -1],
    ])
    shapes = module.ShapeKind
    made.add_geometry(-1, IDENTITY, shapes.HULL, np.zeros(3), corners, planes, *NONE[2:])
    made.add_geometry(-1, IDENTITY, shapes.ELLIPSOID, np.full(3, 0.2), *NONE)
    made.add_geometry(-1, at(0.0, -1.0), shapes.HALF_SPACE, np.zeros(3), *NONE)
    made.add_pairs(np.array([0, 4, 0, 5, 1, 6, 2, 4, 0, 2, 1, 3, 4, 5], dtype=np.int64))
    return made


def at(x: float, z: float) -> np.ndarray:
    """Return the pose of a frame that is parallel to its parent."""
    return np.array([*IDENTITY[:9], x, 0.0, z])


def _geometry(link: int) -> dict[str, Any]:
    module: Any = native()
    sphere = np.array([[0.0, 0.0, 0.0, 0.1]])
    names = ("vertices", "planes", "outer", "inner", "bound")
    values = (*NONE[:2], sphere, NONE[3], sphere[0])
    given = {"link": link, "X_LG": IDENTITY, "kind": module.ShapeKind.SPHERE}
    return given | {"size": np.array([0.1, 0.0, 0.0])} | dict(zip(names, values, strict=True))


def group(*, floats: bool) -> dict[str, tuple[Any, int]]:
    """Return the arguments of a group: two joints, and maybe the floating one."""
    return {
        "scene": (scene(), OBJECT),
        "positions": (np.arange(11 if floats else 4), INDICES),
        "velocities": (np.arange(10 if floats else 4), INDICES),
        "state": (STATE, EXACT),
    }


def checker() -> Any:
    module: Any = native()
    return module.Checker(
        *(value for value, _ in group(floats=False).values()), np.full((7, 2), 0.01)
    )


def chain(*, floats: bool = True) -> Any:
    module: Any = native()
    return module.Chain(*(value for value, _ in group(floats=floats).values()), 2, IDENTITY)


def masses() -> dict[str, tuple[Any, int]]:
    """Return masses of four links, motors, and gravity."""
    inertias = np.concatenate([np.ones((4, 1)), np.zeros((4, 3)), np.tile(IDENTITY[:9], (4, 1))], 1)
    return {
        "inertias": (inertias, EXACT),
        "rotors": (np.full(NV, 0.1), EXACT),
        "gravity": (np.array([0.0, 0.0, -9.81]), EXACT),
    }


def dynamics(*, floats: bool = True) -> Any:
    module: Any = native()
    given = (value for value, _ in (group(floats=floats) | masses()).values())
    return module.InverseDynamics(*given)


def trees() -> Any:
    module: Any = native()
    q = np.zeros(4)
    return module.RrtConnect(checker(), q, q[None] + 0.1, q - 1, q + 1, 0.5, 0.1, 7)


def distance_query() -> Any:
    module: Any = native()
    return module.DistanceQuery(*(value for value, _ in group(floats=True).values()))


def curve() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a motion in two pieces: breaks, bases, coefficients."""
    bases = np.repeat(STATE[None, :11], 2, axis=0)
    # The first joint turns; the second piece begins where the first ends.
    bases[1, 0] = 2.0
    coefficients = np.zeros((2, 3, 10))
    coefficients[:, 1, 0] = 2.0
    return np.array([0.0, 1.0, 2.0]), bases, coefficients


def prover(margin: float = 0.0) -> Any:
    module: Any = native()
    given = (value for value, _ in group(floats=True).values())
    return module.Prover(*given, curve(), np.full(7, margin), 0.0)


def beside_prover(margin: float = 0.0, **changes: Any) -> Any:
    """Return a prover of the first two joints beside the floating one.

    The second motion's arrays have the names of the first's with `other_` before them.
    """
    module: Any = native()
    breaks, bases, coefficients = curve()
    given = {
        "scene": scene(),
        "positions": np.arange(4),
        "velocities": np.arange(4),
        "breaks": breaks,
        "bases": bases[:, :4],
        "coefficients": coefficients[:, :, :4],
        "other_positions": np.arange(4, 11),
        "other_velocities": np.arange(4, 10),
        "other_breaks": breaks,
        "other_bases": bases[:, 4:],
        "other_coefficients": coefficients[:, :, 4:],
        "state": STATE,
        "margins": np.full(7, margin),
        "slack": 0.0,
    } | changes
    names = ("positions", "velocities", "breaks", "bases", "coefficients")
    first, second = (
        tuple(np.ascontiguousarray(given[prefix + name]) for name in names)
        for prefix in ("", "other_")
    )
    rest = (given[name] for name in ("state", "margins", "slack"))
    return module.BesideProver(given["scene"], first, second, *rest)


def tolerance() -> Any:
    module: Any = native()
    return module.IkTolerance(np.zeros(3), module.Freedom.BALL, 0, 0.0)


def with_curve(function: Callable[..., Any], **given: Any) -> Any:
    curve = tuple(given.pop(name) for name in ("breaks", "bases", "coefficients"))
    return function(curve=curve, **given)


def with_program(function: Callable[..., Any], **given: Any) -> Any:
    variables = tuple(given.pop(name) for name in ("c", "q_diagonal", "lower", "upper"))
    rows = tuple(given.pop(name) for name in ("starts", "columns", "values"))
    products = tuple(given.pop(name) for name in ("point_columns", "weights", "slopes"))
    balls = tuple(given.pop(f"ball_{name}") for name in ("starts", "columns", "values", "centers"))
    return function(variables=variables, rows=rows, products=products, balls=balls, **given)


def calls() -> dict[str, Call]:
    """Return a valid call of everything that is exported, by name."""
    module: Any = native()
    made, qs, q = scene(), np.zeros((5, 4)), np.zeros(4)
    with_ball = np.repeat(STATE[None, :11], 3, axis=0)
    resolution = {"resolution": (0.1, SCALAR)}
    geometry = _geometry(0)
    rules = (INDEX, EXACT, KIND, EXACT, ROWS, ROWS, ROWS, ROWS, EXACT)
    ones = np.ones(2)
    return {
        "Scene": call(module.Scene, num_positions=(3, ANY), num_velocities=(3, ANY)),
        "Scene.add_link": call(
            made.add_link, parent=(0, INDEX), X_PF=(IDENTITY, EXACT),
            kind=(module.JointKind.REVOLUTE, KIND), axis=(np.array([0.0, 0.0, 1.0]), EXACT),
            position=(11, INDEX), velocity=(10, INDEX),
        ),
        "Scene.add_follower": call(
            made.add_follower, follower=(11, INDEX), leader=(0, INDEX),
            follower_velocity=(10, INDEX), leader_velocity=(0, INDEX), multiplier=(1.0, SCALAR),
            offset=(0.0, SCALAR),
        ),
        "Scene.add_geometry": call(
            made.add_geometry,
            **{n: (v, rule) for (n, v), rule in zip(geometry.items(), rules, strict=True)},
        ),
        "Scene.add_pair": call(made.add_pair, a=(0, INDEX), b=(1, INDEX)),
        "Scene.add_pairs": call(made.add_pairs, rows=(np.array([0, 4]), INDICES)),
        "Scene.with_poses": call(
            made.with_poses, geometries=(np.array([0, 4]), INDICES),
            X_LG=(np.stack([IDENTITY, IDENTITY]), EXACT),
        ),
        "Scene.near_geometries": call(
            made.near_geometries, full=(STATE, EXACT), first=(4, INDEX), reach=(0.1, SCALAR)
        ),
        "Scene.has_near_pair": call(
            made.has_near_pair, full=(STATE, EXACT), reach=(0.1, SCALAR)
        ),
        "Checker": call(
            module.Checker, **group(floats=False), thresholds=(np.full((7, 2), 0.01), EXACT),
            kernel=("base", OBJECT),
        ),
        "Checker.check": call(checker().check, qs=(qs, ROWS)),
        "Checker.check_free": call(checker().check_free, qs=(qs, ROWS)),
        "Checker.check_one": call(checker().check_one, q=(q, EXACT)),
        "Checker.check_motions": call(
            checker().check_motions, origins=(qs, ROWS), displacements=(qs + 0.3, EXACT),
            **resolution,
        ),
        "Checker.check_motion": call(
            checker().check_motion, origin=(q, EXACT), displacement=(q + 0.3, EXACT), **resolution
        ),
        "Checker.check_edges": call(
            checker().check_edges, q0s=(qs, ROWS), q1s=(qs + 0.3, EXACT), **resolution,
            most=(4096, ANY),
        ),
        "Checker.first_edge": call(
            checker().first_edge, q0s=(qs, ROWS), q1s=(qs + 0.3, EXACT), **resolution,
            most=(4096, ANY),
        ),
        "Checker.check_edge": call(
            checker().check_edge, q0=(q.tolist(), OBJECT), q1=((q + 0.3).tolist(), OBJECT),
            **resolution,
        ),
        "RrtConnect": call(
            module.RrtConnect, checker=(checker(), OBJECT), start=(q, EXACT),
            goals=(qs + 0.1, ROWS), lower=(q - 1, EXACT), upper=(q + 1, EXACT),
            max_step=(0.5, SCALAR), resolution=(0.1, SCALAR), seed=(7, ANY),
        ),
        "RrtConnect.path": call(trees().path),
        "RrtConnect.solve": call(
            trees().solve, is_free=(lambda *_: False, OBJECT), report=(lambda: None, OBJECT),
            max_states=(100.0, ANY), max_samples=(100.0, ANY),
        ),
        **shortcut_calls(checker()),
        "first_of_clusters": call(
            module.first_of_clusters, rows=(with_ball, ROWS),
            targets=(np.zeros(3, np.int64), EXACT),
            is_periodic=(np.ones(11, dtype=bool), ANY), tolerance=(1e-3, SCALAR),
        ),
        "IkTolerance": call(
            module.IkTolerance, box=(np.zeros(3), EXACT), freedom=(module.Freedom.CONE, KIND),
            axis=(1, INDEX), bound=(0.1, SCALAR),
        ),
        "Chain": call(module.Chain, **group(floats=True), link=(2, INDEX), X_LT=(IDENTITY, EXACT)),
        "Chain.poses": call(chain().poses, qs=(with_ball, ROWS)),
        "Chain.jacobians": call(chain().jacobians, qs=(with_ball, ROWS)),
        "Chain.velocities": call(
            chain(floats=False).velocities, qs=(np.zeros((3, 4)), SIZING),
            vs=(np.zeros((3, 4)), EXACT),
        ),
        "Chain.velocity_gradients": call(
            chain(floats=False).velocity_gradients, qs=(np.zeros((3, 4)), SIZING),
            vs=(np.zeros((3, 4)), EXACT),
        ),
        "Chain.solve": call(
            chain().solve, seeds=(with_ball, ROWS), target_of=(np.zeros(3, np.int64), INDICES),
            targets=(IDENTITY[None], ROWS), lower=(np.full(11, -9.0), EXACT),
            upper=(np.full(11, 9.0), EXACT), tolerance=(tolerance(), OBJECT), enough=(9, ANY),
            max_iterations=(20, ANY), kernel=("base", OBJECT),
        ),
        "InverseDynamics": call(module.InverseDynamics, **group(floats=True), **masses()),
        "InverseDynamics.efforts": call(
            dynamics().efforts, q=(with_ball, SIZING), v=(np.ones((len(with_ball), 10)), EXACT),
            vdot=(np.ones((len(with_ball), 10)), EXACT),
        ),
        "InverseDynamics.derivatives": call(
            dynamics(floats=False).derivatives, q=(np.zeros((3, 4)), SIZING),
            v=(np.ones((3, 4)), EXACT), vdot=(np.ones((3, 4)), EXACT),
        ),
        "DistanceQuery": call(module.DistanceQuery, **group(floats=True)),
        "DistanceQuery.within": call(
            distance_query().within, qs=(with_ball, ROWS), reach=(np.full(7, 9.0), EXACT)
        ),
        "Prover": call(
            partial(with_curve, module.Prover), **group(floats=True), breaks=(curve()[0], EXACT),
            bases=(curve()[1], EXACT), coefficients=(curve()[2], SIZING),
            margins=(np.zeros(7), EXACT), slack=(0.0, SCALAR),
        ),
        "Prover.prove": call(prover().prove, interrupt=(int, OBJECT)),
        "Prover.prove_in_order": call(
            prover().prove_in_order, interrupt=(int, OBJECT), resolution=(1e-3, SCALAR)
        ),
        "BesideProver": call(
            beside_prover, positions=(np.arange(4), INDICES), velocities=(np.arange(4), INDICES),
            breaks=(curve()[0], EXACT), bases=(np.ascontiguousarray(curve()[1][:, :4]), EXACT),
            coefficients=(np.ascontiguousarray(curve()[2][:, :, :4]), SIZING),
            state=(STATE, EXACT), margins=(np.zeros(7), EXACT), slack=(0.0, SCALAR),
        ),
        "BesideProver.prove": call(beside_prover().prove, interrupt=(int, OBJECT)),
        "Prover.bounds": call(prover().bounds, halvings=([0, 1, 1], INDICES)),
        **load_calls(module),
        **timing_calls(module),
        **curve_calls(module),
        "batch_kernels": call(module.batch_kernels),
        "joint_bounds": call(
            partial(with_curve, module.joint_bounds), breaks=(np.array([0.0, 1.0]), EXACT),
            bases=(np.zeros((1, 2)), EXACT), coefficients=(np.ones((1, 3, 2)), ANY),
            lower=(-np.ones(2), EXACT), upper=(np.ones(2), EXACT), rates=(np.ones((2, 2)), ANY),
            position_tolerance=(1e-8, SCALAR), rate_gap=(1e-8, SCALAR),
        ),
        "peak": call(module.peak, coefficients=(np.ones((2, 3)), ANY), tolerance=(1e-6, ANY)),
        "solve_penalty_qp": call(
            partial(with_program, module.solve_penalty_qp), c=(ones, SIZING),
            q_diagonal=(ones, EXACT), lower=(-ones, EXACT), upper=(ones, EXACT),
            starts=(np.array([0, 1, 2]), OBJECT),
            columns=(np.array([0, 1]), INDICES), values=(ones, EXACT),
            point_columns=(np.array([[0]]), OBJECT), weights=(ones[None, :1], SIZING),
            slopes=(ones[None], ANY), ball_starts=(np.array([0, 2]), OBJECT),
            ball_columns=(np.array([0, 1]), INDICES), ball_values=(np.ones(6), EXACT),
            ball_centers=(np.zeros(3), EXACT), least=(np.zeros(4), SIZING),
            price=(np.ones(4), EXACT), tolerance=(1e-6, ANY), max_steps=(20, ANY),
        ),
    }  # fmt: skip


def _can_be_made(kind: type) -> bool:
    try:
        kind()
    except TypeError as refusal:
        return "no constructor" not in str(refusal)
    return True


def exported() -> set[str]:
    """Return the names of everything in the native module that takes arguments."""
    module: Any = native()
    names = set()
    for name, value in inspect.getmembers(module):
        if name.startswith("_") or (isinstance(value, type) and issubclass(value, Enum)):
            continue
        if not isinstance(value, type):
            names.add(name)
            continue
        if _can_be_made(value):
            names.add(name)
        methods = inspect.getmembers(value, lambda each: type(each).__name__ == "nb_method")
        names |= {f"{name}.{method}" for method, _ in methods if not method.startswith("_")}
    return names
