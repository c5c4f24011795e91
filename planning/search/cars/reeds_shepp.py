"""Reeds-Shepp curves: the shortest paths of a car that drives forwards and backwards.

Each is one of 48 words of up to five segments (Reeds and Shepp, "Optimal paths for a car that goes
both forwards and backwards", Pacific Journal of Mathematics 145:2, 1990; docstrings below give the
numbers of the formulas in section 8; OMPL uses the same ones, with the misprints of the paper
corrected). A formula for one word gives four by symmetry: driven backwards (x, yaw -> -x, -yaw),
mirrored (y, yaw -> -y, -yaw), and both. Some give four more by being driven from the goal to the
start. In the names p and m stand for forwards and backwards, and a segment without either has both
cases.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.search.cars.path_words import PathWords, rounded_sqrt, shortest_words

type Formula = Callable[[Array, Array, Array], tuple[list[Array], Any]]

_QUARTER = np.pi / 2
# Lengths that are negative by no more than this count as zero.
_ROUNDING = 1e-11
_L, _S, _R = 1, 0, -1


def reeds_shepp_words(goals: Float64[np.ndarray, "m 3"]) -> PathWords:
    """Return the shortest word to each goal: x, y [radii] and yaw in the frame of the start."""
    x, y, yaw = goals.T
    # All four symmetric goals, one after another.
    symmetric_goals = (
        np.concatenate([x, -x, x, -x]),
        np.concatenate([y, y, -y, -y]),
        np.concatenate([yaw, -yaw, -yaw, yaw]),
    )
    c, s = np.cos(symmetric_goals[2]), np.sin(symmetric_goals[2])
    reversed_goals = (
        symmetric_goals[0] * c + symmetric_goals[1] * s,
        symmetric_goals[0] * s - symmetric_goals[1] * c,
        symmetric_goals[2],
    )
    lengths = np.zeros((len(_WORDS), 4, len(goals), 5))
    with np.errstate(invalid="ignore"):
        for word, (formula, _, is_from_goal) in zip(lengths, _WORDS, strict=True):
            segments, exists = formula(*(reversed_goals if is_from_goal else symmetric_goals))
            for k, segment in enumerate(segments[::-1] if is_from_goal else segments):
                word[:, :, k] = segment.reshape(4, -1)
            word[~exists.reshape(4, -1)] = np.inf
    lengths *= _DIRECTION_SIGNS[:, None, None]
    return shortest_words(lengths.reshape(-1, len(goals), 5), _TURNS, goals)


def _lp_sp_lp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ S+ L+ by formula 8.1, and where it exists."""
    u, t = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    v = _wrap_angle(yaw - t)
    return [t, u, v], _is_not_negative(t) & _is_not_negative(v)


def _lp_sp_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ S+ R+ by formula 8.2, and where it exists."""
    rho, theta = _polar(x + np.sin(yaw), y - 1 - np.cos(yaw))
    u = rounded_sqrt(rho**2 - 4)
    t = _wrap_angle(theta + np.arctan2(2.0, u))
    v = _wrap_angle(t - yaw)
    return [t, u, v], _is_not_negative(t) & _is_not_negative(v)


def _lp_rm_l(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- L by formulas 8.3 and 8.4 (a misprint in the paper is corrected)."""
    rho, theta = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    u = -2 * np.arcsin(rho / 4)
    t = _wrap_angle(theta + u / 2 + np.pi)
    v = _wrap_angle(yaw - t + u)
    return [t, u, v], (rho <= 4) & _is_not_negative(t)


def _lp_rup_lum_rm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R+ L- R- with equal middle arcs by formula 8.7, and where it exists."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    rho = (2 + np.hypot(xi, eta)) / 4
    u = np.arccos(rho)
    t, v = _tau_omega(u, -u, (xi, eta, yaw))
    return [t, u, -u, v], (rho <= 1) & _is_not_negative(t) & _is_not_negative(-v)


def _lp_rum_lum_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- L- R+ with equal middle arcs by formula 8.8, and where it exists."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    rho = (20 - xi**2 - eta**2) / 16
    u = -np.arccos(rho)
    t, v = _tau_omega(u, u, (xi, eta, yaw))
    return [t, u, u, v], (rho >= 0) & (rho <= 1) & _is_not_negative(t) & _is_not_negative(v)


def _lp_rm_sm_lm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- L- by formula 8.9, and where it exists."""
    rho, theta = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    r = rounded_sqrt(rho**2 - 4)
    t = _wrap_angle(theta + np.arctan2(r, -2.0))
    v = _wrap_angle(yaw - _QUARTER - t)
    return [t, _quarter_backwards(t), 2 - r, v], _is_not_negative(t) & _is_not_negative(
        r - 2
    ) & _is_not_negative(-v)


def _lp_rm_sm_rm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- R- by formula 8.10, and where it exists."""
    rho, t = _polar(1 + np.cos(yaw) - y, x + np.sin(yaw))
    v = _wrap_angle(t + _QUARTER - yaw)
    return [t, _quarter_backwards(t), 2 - rho, v], (rho >= 2) & _is_not_negative(
        t
    ) & _is_not_negative(-v)


def _lp_rm_s_lm_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- L- R+ by formula 8.11 (a misprint in the paper is corrected)."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    u = 4 - rounded_sqrt(np.hypot(xi, eta) ** 2 - 4)
    t = _wrap_angle(np.arctan2((4 - u) * xi - 2 * eta, -2 * xi + (u - 4) * eta))
    v = _wrap_angle(t - yaw)
    return [t, _quarter_backwards(t), u, _quarter_backwards(t), v], _is_not_negative(
        -u
    ) & _is_not_negative(t) & _is_not_negative(v)


# Formula, turns of its segments, and whether the word is driven from the goal to the start.
_WORDS: tuple[tuple[Formula, tuple[int, ...], bool], ...] = (
    (_lp_sp_lp, (_L, _S, _L), False),
    (_lp_sp_rp, (_L, _S, _R), False),
    (_lp_rm_l, (_L, _R, _L), False),
    (_lp_rm_l, (_L, _R, _L), True),
    (_lp_rup_lum_rm, (_L, _R, _L, _R), False),
    (_lp_rum_lum_rp, (_L, _R, _L, _R), False),
    (_lp_rm_sm_lm, (_L, _R, _S, _L), False),
    (_lp_rm_sm_lm, (_L, _S, _R, _L), True),
    (_lp_rm_sm_rm, (_L, _R, _S, _R), False),
    (_lp_rm_sm_rm, (_R, _S, _R, _L), True),
    (_lp_rm_s_lm_rp, (_L, _R, _S, _L, _R), False),
)
# Signs of the four symmetric goals: direction of driving, and side of the turns.
_DIRECTION_SIGNS = np.array([1.0, -1.0, 1.0, -1.0])
_SIDE_SIGNS = np.array([1.0, 1.0, -1.0, -1.0])
_PADDED_TURNS = np.array(
    [[*turns, *[_S] * (5 - len(turns))] for _, turns, _ in _WORDS], dtype=float
)
_TURNS = (_SIDE_SIGNS[:, None] * _PADDED_TURNS[:, None]).reshape(-1, 5)


def _tau_omega(u: Array, v: Array, goal: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Return the first and the last of four arcs (8.7 and 8.8), given the two between."""
    xi, eta, yaw = goal
    delta = _wrap_angle(u - v)
    a, b = np.sin(u) - np.sin(delta), np.cos(u) - np.cos(delta) - 1
    theta = np.arctan2(eta * a - xi * b, xi * a + eta * b)
    is_behind = 2 * (np.cos(delta) - np.cos(v) - np.cos(u)) + 3 < 0
    tau = _wrap_angle(np.where(is_behind, theta + np.pi, theta))
    return tau, _wrap_angle(tau - u + v - yaw)


def _polar(x: Array, y: Array) -> tuple[Array, Array]:
    return np.hypot(x, y), np.arctan2(y, x)


def _wrap_angle(angle: Array) -> Array:
    """Return an angle in (-pi, pi]."""
    return -(np.remainder(np.pi - angle, 2 * np.pi) - np.pi)


def _is_not_negative(length: Array) -> Any:
    return length >= -_ROUNDING


def _quarter_backwards(like: Array) -> Array:
    return np.full_like(like, -_QUARTER)
