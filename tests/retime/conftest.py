"""Let our own module import toppra first: it silences what Python says of toppra's docstrings."""

import planning.retime.toppra.toppra_passes  # noqa: F401 - for what importing it does
