"""Stop constraints other than joint rates: accelerations of frames, and torques.

Along t = s(clock) the origin of a frame has the acceleration p'' s'^2 + p' s''. Both derivatives
are evaluated at a few instants of every cell; between these each is within h^2 / 8 of its own
second derivative from linear, as in `frame_proof`. The torques' shares are Taylor polynomials about
the middles of the cells, with bounds on their remainders, as in `taylor_torques`.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from planning.certify.frames.frame_derivative_bounds import origin_bounds
from planning.certify.frames.frame_states import FrameStates
from planning.certify.intervals import bernstein
from planning.certify.intervals.motion_cells import MotionCells
from planning.certify.joints.limit_checks import MAX_UTILIZATION
from planning.certify.request import CertifyRequest
from planning.certify.stopping.stop_constraint import StopConstraint
from planning.certify.torque.links import Link, links_of
from planning.certify.torque.taylor_torques import TorquePolynomials, torque_series
from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Number of evaluations of a frame in each cell after the one at its beginning.
_NUM_SAMPLES = 8
_BATCH_SIZE = 256


def with_stop_constraints(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> MotionCells:
    """Return the cells with all constraints on stops other than joint rates.

    Raises:
        ModelInvalid: A joint of a kind that cannot be certified, or a moving body without known
            mass.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    constraints = [
        _frame_constraint(model, request, cells, (limit.frame, limit.acceleration), deadline)
        for limit in request.tool_limits
        if limit.acceleration is not None
    ]
    if request.effort:
        constraints += _torque_constraints(model, request, cells, deadline)
    return replace(cells, stop_constraints=tuple(constraints))


def _frame_constraint(
    model: DrakeModel,
    request: CertifyRequest,
    cells: MotionCells,
    limit: tuple[str, float],
    deadline: Deadline,
) -> StopConstraint:
    frame, max_acceleration = limit
    pieces, begins = _locate_cells(request, cells)
    fractions = np.linspace(0.0, 1.0, _NUM_SAMPLES + 1)
    local = begins[:, None] + fractions * cells.widths[:, None]
    states = FrameStates(model, request, frame)
    motion = states.at(np.repeat(pieces, len(fractions)), local.ravel(), deadline)
    shape = (len(pieces), len(fractions), 1, 3)
    with np.errstate(over="ignore", invalid="ignore"):
        point = origin_bounds(model, request, frame)
        higher_derivatives = point.derivatives[pieces, 2:]
        errors = (cells.widths[:, None] / _NUM_SAMPLES) ** 2 / 8 * higher_derivatives
        errors += point.errors[pieces, 1:]
        bounds = max_acceleration * MAX_UTILIZATION - errors[:, 1:]
    constraint = StopConstraint(
        (f"tool_acceleration {frame}",),
        motion.velocity.reshape(shape),
        motion.acceleration.reshape(shape),
        np.zeros((len(pieces), 1, 1, 1)),
        None,
        errors[:, :1],
        bounds,
    )
    return constraint.without_overflow


def _torque_constraints(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> list[StopConstraint]:
    """Return the torque constraints of all blocks with effort limits, grouped by size."""
    limits = request.limits
    limited = [i for i in range(len(limits.effort)) if np.isfinite(limits.effort[i])]
    terms = _torque_terms(model, request, cells, deadline) if limited else []
    constraints: list[StopConstraint] = []
    for size in sorted({len(limits.blocks[i]) for i in limited}):
        chosen = [i for i in limited if len(limits.blocks[i]) == size]
        columns = np.array([list(limits.blocks[i]) for i in chosen])
        (by_path_acceleration, path_acceleration_error), *others = (
            (
                bernstein.about_middle(term.taylor, cells.widths / 2)[:, :, columns],
                np.linalg.norm(term.errors[:, columns], axis=2),
            )
            for term in terms
        )
        by_squared_path_velocity, constant, *by_path_velocity = (form for form, _ in others)
        errors = np.sum([error for _, error in others], axis=0)
        names = tuple(f"torque {request.group.blocks[i][0]}" for i in chosen)
        bounds = limits.effort[chosen] * MAX_UTILIZATION - errors
        constraint = StopConstraint(
            names,
            by_path_acceleration,
            by_squared_path_velocity,
            constant,
            by_path_velocity[0] if by_path_velocity else None,
            path_acceleration_error,
            bounds,
        )
        constraints.append(constraint.without_overflow)
    return constraints


def _torque_terms(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> list[TorquePolynomials]:
    """Return the torques' shares of s'', of s'^2, of gravity, and of s' if a joint is damped."""
    links = links_of(model, request)
    gravity = np.array(model.plant.gravity_field().gravity_vector())
    undamped = tuple(replace(link, motion=replace(link.motion, damping=0.0)) for link in links)
    terms = [(undamped, 0 * gravity, 1), (undamped, 0 * gravity, 2), (undamped, gravity, 0)]
    if any(link.motion.damping for link in links):
        terms.append((links, 0 * gravity, 0))
    return [
        _torque_term(term, request, cells, deadline, use_kernel=model.uses_kernel) for term in terms
    ]


def _torque_term(
    term: tuple[tuple[Link, ...], Array, int],
    request: CertifyRequest,
    cells: MotionCells,
    deadline: Deadline,
    *,
    use_kernel: bool,
) -> TorquePolynomials:
    links, gravity, order = term
    pieces, begins = _locate_cells(request, cells)
    halves = cells.widths / 2
    parts: list[TorquePolynomials] = []
    for begin in range(0, len(pieces), _BATCH_SIZE):
        deadline.check("certify")
        rows = slice(begin, begin + _BATCH_SIZE)
        segments = pieces[rows], begins[rows] + halves[rows], halves[rows]
        # Overflow gives NaN: the torque is unknown there.
        with np.errstate(over="ignore", invalid="ignore"):
            part = torque_series(
                links, gravity, request.trajectory, segments, order, use_kernel=use_kernel
            )
        parts.append(part)
    return TorquePolynomials(
        np.concatenate([part.taylor for part in parts]),
        np.concatenate([part.errors for part in parts]),
    )


def _locate_cells(request: CertifyRequest, cells: MotionCells) -> tuple[Any, Array]:
    """Return the piece of every cell, and the cell's beginning since the piece's break [s]."""
    breaks = request.trajectory.breaks
    pieces = np.searchsorted(breaks, cells.begins + cells.widths / 2) - 1
    return pieces, cells.begins - breaks[pieces]
