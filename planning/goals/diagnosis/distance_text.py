"""Text of distances and angles for messages, with enough digits that small values do not read 0."""

import math

# Values below this are written with two significant digits [mm, deg].
_SMALL_LENGTH, _SMALL_ANGLE = 0.05, 0.005


def millimetres(length: float) -> str:
    """Return a length [m] as text in millimetres; only 0 reads as 0."""
    number = 1000 * length
    return f"{_digits(number, 1, _SMALL_LENGTH)} mm"


def degrees(angle: float) -> str:
    """Return an angle [rad] as text in degrees; only 0 reads as 0."""
    return f"{_digits(math.degrees(angle), 2, _SMALL_ANGLE)} deg"


def _digits(number: float, decimals: int, small: float) -> str:
    is_small = 0 < abs(number) < small
    return f"{number:.2g}" if is_small else f"{number:.{decimals}f}"
