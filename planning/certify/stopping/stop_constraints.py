"""Stop constraints other than joint rates: accelerations of frames, and torques.

Along t = s(clock) the origin of a frame has the acceleration p'' s'^2 + p' s''. Both derivatives
are evaluated at a few instants of every cell; between these each is within h^2 / 8 of its own
second derivative from linear, as in `frame_proof`. The torques' shares are Taylor polynomials about
the middles of the cells, with bounds on their remainders, as in `taylor_torques`.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from planning.certify.frames.frame_chain import derivative_bounds, origin_errors
from planning.certify.frames.frame_states import FrameStates
from planning.certify.intervals import bernstein
from planning.certify.intervals.motion_cells import MotionCells
from planning.certify.joints.limit_checks import MAX_UTILISATION
from planning.certify.request import CertifyRequest
from planning.certify.stopping.stop_constraint import StopConstraint
from planning.certify.torque.links import Link, links_of
from planning.certify.torque.taylor_torques import Torques, torque_series
from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel

# Number of evaluations of a frame in each cell after the one at its beginning.
_LOOKS = 8
_AT_ONCE = 256


def with_constraints(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> MotionCells:
    """Return the cells with all constraints on stops other than joint rates.

    Raises:
        ModelInvalid: A joint of a kind that cannot be certified, or a moving body without known
            mass.
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
    """
    loads = [
        _of_frame(model, request, cells, (limit.frame, limit.acceleration), deadline)
        for limit in request.tool_limits
        if limit.acceleration is not None
    ]
    if request.effort:
        loads += _of_torques(model, request, cells, deadline)
    return replace(cells, loads=tuple(loads))


def _of_frame(
    model: DrakeModel,
    request: CertifyRequest,
    cells: MotionCells,
    limit: tuple[str, float],
    deadline: Deadline,
) -> StopConstraint:
    frame, most = limit
    pieces, begins = _placed(request, cells)
    places = np.linspace(0.0, 1.0, _LOOKS + 1)
    local = begins[:, None] + places * cells.widths[:, None]
    states = FrameStates(model, request, frame)
    seen = states.at(np.repeat(pieces, len(places)), local.ravel(), deadline)
    shape = (len(pieces), len(places), 1, 3)
    with np.errstate(over="ignore", invalid="ignore"):
        beyond = derivative_bounds(model, request, frame)[pieces, 2:]
        off = (cells.widths[:, None] / _LOOKS) ** 2 / 8 * beyond
        off += origin_errors(model, request, frame)[pieces, 1:]
        bounds = most * MAX_UTILISATION - off[:, 1:]
    load = StopConstraint(
        (f"tool_acceleration {frame}",),
        seen.velocity.reshape(shape),
        seen.acceleration.reshape(shape),
        np.zeros((len(pieces), 1, 1, 1)),
        None,
        off[:, :1],
        bounds,
    )
    return load.where_known


def _of_torques(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> list[StopConstraint]:
    """Return the torque constraints of all blocks with effort limits, grouped by size."""
    limits = request.limits
    limited = [i for i in range(len(limits.effort)) if np.isfinite(limits.effort[i])]
    shares = _shares(model, request, cells, deadline) if limited else []
    loads: list[StopConstraint] = []
    for size in sorted({len(limits.blocks[i]) for i in limited}):
        chosen = [i for i in limited if len(limits.blocks[i]) == size]
        columns = np.array([list(limits.blocks[i]) for i in chosen])
        (slope, off), *others = (
            (
                bernstein.about_middle(share.taylor, cells.widths / 2)[:, :, columns],
                np.linalg.norm(share.missed[:, columns], axis=2),
            )
            for share in shares
        )
        bend, rest, *drag = (form for form, _ in others)
        missed = np.sum([beyond for _, beyond in others], axis=0)
        names = tuple(f"torque {request.group.blocks[i][0]}" for i in chosen)
        bounds = limits.effort[chosen] * MAX_UTILISATION - missed
        load = StopConstraint(names, slope, bend, rest, drag[0] if drag else None, off, bounds)
        loads.append(load.where_known)
    return loads


def _shares(
    model: DrakeModel, request: CertifyRequest, cells: MotionCells, deadline: Deadline
) -> list[Torques]:
    """Return the torques' shares of s'', of s'^2, of gravity, and of s' if a joint is damped."""
    links = links_of(model, request)
    gravity = np.array(model.plant.gravity_field().gravity_vector())
    free = tuple(replace(link, motion=replace(link.motion, damping=0.0)) for link in links)
    wanted = [(free, 0 * gravity, 1), (free, 0 * gravity, 2), (free, gravity, 0)]
    if any(link.motion.damping for link in links):
        wanted.append((links, 0 * gravity, 0))
    return [_share(share, request, cells, deadline) for share in wanted]


def _share(
    share: tuple[tuple[Link, ...], Array, int],
    request: CertifyRequest,
    cells: MotionCells,
    deadline: Deadline,
) -> Torques:
    links, gravity, order = share
    pieces, begins = _placed(request, cells)
    halves = cells.widths / 2
    parts: list[Torques] = []
    for begin in range(0, len(pieces), _AT_ONCE):
        deadline.check("certify")
        rows = slice(begin, begin + _AT_ONCE)
        where = pieces[rows], begins[rows] + halves[rows], halves[rows]
        # Overflow gives NaN: the torque is unknown there.
        with np.errstate(over="ignore", invalid="ignore"):
            parts.append(torque_series(links, gravity, request.trajectory, where, order))
    return Torques(
        np.concatenate([part.taylor for part in parts]),
        np.concatenate([part.missed for part in parts]),
    )


def _placed(request: CertifyRequest, cells: MotionCells) -> tuple[Any, Array]:
    """Return the piece of every cell, and the cell's beginning since the piece's break [s]."""
    breaks = request.trajectory.breaks
    pieces = np.searchsorted(breaks, cells.begins + cells.widths / 2) - 1
    return pieces, cells.begins - breaks[pieces]
