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
from planning.search.cars.path_words import PathWords, root, shortest

type Formula = Callable[[Array, Array, Array], tuple[list[Array], Any]]

_QUARTER = np.pi / 2
# Lengths that are negative by no more than this count as zero.
_NOTHING = 1e-11
_L, _S, _R = 1, 0, -1


def reeds_shepp_words(goals: Float64[np.ndarray, "m 3"]) -> PathWords:
    """Return the shortest word to each goal: x, y [radii] and yaw in the frame of the start."""
    x, y, yaw = goals.T
    # All four symmetric goals, one after another.
    seen = (
        np.concatenate([x, -x, x, -x]),
        np.concatenate([y, y, -y, -y]),
        np.concatenate([yaw, -yaw, -yaw, yaw]),
    )
    c, s = np.cos(seen[2]), np.sin(seen[2])
    backwards = seen[0] * c + seen[1] * s, seen[0] * s - seen[1] * c, seen[2]
    lengths = np.zeros((len(_WORDS), 4, len(goals), 5))
    with np.errstate(invalid="ignore"):
        for word, (formula, _, is_from_goal) in zip(lengths, _WORDS, strict=True):
            letters, exists = formula(*(backwards if is_from_goal else seen))
            for k, letter in enumerate(letters[::-1] if is_from_goal else letters):
                word[:, :, k] = letter.reshape(4, -1)
            word[~exists.reshape(4, -1)] = np.inf
    lengths *= _DRIVEN[:, None, None]
    return shortest(lengths.reshape(-1, len(goals), 5), _TURNS, goals)


def _lp_sp_lp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ S+ L+ by formula 8.1, and where it exists."""
    u, t = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    v = _half(yaw - t)
    return [t, u, v], _least(t) & _least(v)


def _lp_sp_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ S+ R+ by formula 8.2, and where it exists."""
    rho, course = _polar(x + np.sin(yaw), y - 1 - np.cos(yaw))
    u = root(rho**2 - 4)
    t = _half(course + np.arctan2(2.0, u))
    v = _half(t - yaw)
    return [t, u, v], _least(t) & _least(v)


def _lp_rm_l(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- L by formulas 8.3 and 8.4 (a misprint in the paper is corrected)."""
    rho, course = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    u = -2 * np.arcsin(rho / 4)
    t = _half(course + u / 2 + np.pi)
    v = _half(yaw - t + u)
    return [t, u, v], (rho <= 4) & _least(t)


def _lp_rup_lum_rm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R+ L- R- with equal middle arcs by formula 8.7, and where it exists."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    rho = (2 + np.hypot(xi, eta)) / 4
    u = np.arccos(rho)
    t, v = _tau_omega(u, -u, (xi, eta, yaw))
    return [t, u, -u, v], (rho <= 1) & _least(t) & _least(-v)


def _lp_rum_lum_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- L- R+ with equal middle arcs by formula 8.8, and where it exists."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    rho = (20 - xi**2 - eta**2) / 16
    u = -np.arccos(rho)
    t, v = _tau_omega(u, u, (xi, eta, yaw))
    return [t, u, u, v], (rho >= 0) & (rho <= 1) & _least(t) & _least(v)


def _lp_rm_sm_lm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- L- by formula 8.9, and where it exists."""
    rho, course = _polar(x - np.sin(yaw), y - 1 + np.cos(yaw))
    r = root(rho**2 - 4)
    t = _half(course + np.arctan2(r, -2.0))
    v = _half(yaw - _QUARTER - t)
    return [t, _back(t), 2 - r, v], _least(t) & _least(r - 2) & _least(-v)


def _lp_rm_sm_rm(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- R- by formula 8.10, and where it exists."""
    rho, t = _polar(1 + np.cos(yaw) - y, x + np.sin(yaw))
    v = _half(t + _QUARTER - yaw)
    return [t, _back(t), 2 - rho, v], (rho >= 2) & _least(t) & _least(-v)


def _lp_rm_s_lm_rp(x: Array, y: Array, yaw: Array) -> tuple[list[Array], Any]:
    """Return the word L+ R- S- L- R+ by formula 8.11 (a misprint in the paper is corrected)."""
    xi, eta = x + np.sin(yaw), y - 1 - np.cos(yaw)
    u = 4 - root(np.hypot(xi, eta) ** 2 - 4)
    t = _half(np.arctan2((4 - u) * xi - 2 * eta, -2 * xi + (u - 4) * eta))
    v = _half(t - yaw)
    return [t, _back(t), u, _back(t), v], _least(-u) & _least(t) & _least(v)


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
_DRIVEN = np.array([1.0, -1.0, 1.0, -1.0])
_TURNED = np.array([1.0, 1.0, -1.0, -1.0])
_PADDED = np.array([[*turns, *[_S] * (5 - len(turns))] for _, turns, _ in _WORDS], dtype=float)
_TURNS = (_TURNED[:, None] * _PADDED[:, None]).reshape(-1, 5)


def _tau_omega(u: Array, v: Array, goal: tuple[Array, Array, Array]) -> tuple[Array, Array]:
    """Return the first and the last of four arcs (8.7 and 8.8), given the two between."""
    xi, eta, yaw = goal
    delta = _half(u - v)
    a, b = np.sin(u) - np.sin(delta), np.cos(u) - np.cos(delta) - 1
    course = np.arctan2(eta * a - xi * b, xi * a + eta * b)
    is_behind = 2 * (np.cos(delta) - np.cos(v) - np.cos(u)) + 3 < 0
    tau = _half(np.where(is_behind, course + np.pi, course))
    return tau, _half(tau - u + v - yaw)


def _polar(x: Array, y: Array) -> tuple[Array, Array]:
    return np.hypot(x, y), np.arctan2(y, x)


def _half(angle: Array) -> Array:
    """Return an angle in (-pi, pi]."""
    return -(np.remainder(np.pi - angle, 2 * np.pi) - np.pi)


def _least(length: Array) -> Any:
    return length >= -_NOTHING


def _back(like: Array) -> Array:
    return np.full_like(like, -_QUARTER)
