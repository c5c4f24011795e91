"""A valid call of something that the native module exports, and rules for its arguments."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# What an argument has to be. EXACT: of one shape; ROWS: of a number of columns; SIZING: of a shape
# that others fit; SCALAR: a finite number; ANY: no rule that a number can break.
INDEX, INDICES, EXACT, ROWS, SIZING, SCALAR, KIND, OBJECT, ANY = range(9)
# Arrays in which NaN is refused; elsewhere it leaves a verdict unsure.
FINITE = {
    "X_PF", "X_LG", "X_LT", "axis", "size", "vertices", "planes", "outer", "inner", "bound",
    "state", "thresholds", "box", "breaks", "bases", "coefficients", "margins", "reach", "least",
    "price", "c", "s", "v", "a", "j", "h", "durations", "parameters", "limits", "positions",
    "q_diagonal", "lower", "upper", "values", "start", "goals", "waypoints", "inertias", "rotors",
    "gravity", "vdot", "middles", "halves", "mass",
}  # fmt: skip


@dataclass(frozen=True)
class Call:
    """A call with arguments that are right, and a rule for each."""

    function: Callable[..., Any]
    arguments: dict[str, Any]
    rules: dict[str, int]

    def __call__(self, **changes: Any) -> Any:
        return self.function(**{**self.arguments, **changes})


def call(function: Callable[..., Any], **arguments: tuple[Any, int]) -> Call:
    return Call(
        function,
        {name: value for name, (value, _) in arguments.items()},
        {name: rule for name, (_, rule) in arguments.items()},
    )
