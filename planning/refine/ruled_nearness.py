"""Path constraints as distances: how much room each leaves along a curve, and how it changes."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.refine.nearness import Near, Nearness
from planning.world.rules.box_rule import BoxRule
from planning.world.rules.cone_rule import ConeRule
from planning.world.rules.joint_rules import LimitRule, LockRule
from planning.world.rules.path_rules import PathRules

type Array = np.ndarray[Any, np.dtype[np.float64]]

# Of the difference quotients [rad or m].
_STEP = 1e-6


class RuledNearness:
    """The inner measure, and boxes and cones as if they were pairs of bodies.

    The room of a rule counts in its own unit, a radian like a metre.
    """

    def __init__(
        self, inner: Nearness, rules: PathRules, positions: Callable[[Array], Array]
    ) -> None:
        """Add to `inner` what has a gradient; `positions` makes configurations of coordinates."""
        self._inner, self._positions = inner, positions
        self._rules = [rule for rule in rules.rules if isinstance(rule, BoxRule | ConeRule)]

    def within(self, qs: Float64[np.ndarray, "m nq"], reach: float) -> Near:
        """Return the pairs and rules with less than `reach` [m or rad] beyond what is demanded."""
        near = [self._inner.within(qs, reach)]
        near += [self._near(rule, qs, reach) for rule in self._rules]
        return Near(
            np.concatenate([part.at for part in near]),
            np.concatenate([part.spare for part in near]),
            np.concatenate([part.gradient for part in near]),
        )

    def _near(self, rule: BoxRule | ConeRule, qs: Array, reach: float) -> Near:
        spare = rule.spares(self._positions(qs)) - rule.room
        at = np.flatnonzero(spare < reach)
        moved = qs[at, None] + _STEP * np.eye(qs.shape[1])
        beyond = rule.spares(self._positions(moved.reshape(-1, qs.shape[1]))) - rule.room
        gradient = (beyond.reshape(moved.shape[:2]) - spare[at, None]) / _STEP
        return Near(at, spare[at], gradient)


def unknown_rules(rules: PathRules) -> tuple[str, ...]:
    """Return the labels of rules that have no gradient here, and are no limits either."""
    known = BoxRule | ConeRule | LimitRule | LockRule
    return tuple(rule.label for rule in rules.rules if not isinstance(rule, known))
