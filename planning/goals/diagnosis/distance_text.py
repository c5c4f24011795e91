"""Small distances and angles in words, in digits that show."""

import math

# Less than this is written with two significant digits, wherever they are [mm, deg].
_SMALL_LENGTH, _SMALL_ANGLE = 0.05, 0.005


def millimetres(length: float) -> str:
    """Return a length in metres as words in millimetres; nothing but 0 reads as 0."""
    number = 1000 * length
    return f"{_digits(number, 1, _SMALL_LENGTH)} mm"


def degrees(angle: float) -> str:
    """Return an angle in radians as words in degrees; nothing but 0 reads as 0."""
    return f"{_digits(math.degrees(angle), 2, _SMALL_ANGLE)} deg"


def _digits(number: float, decimals: int, small: float) -> str:
    is_small = 0 < abs(number) < small
    return f"{number:.2g}" if is_small else f"{number:.{decimals}f}"
