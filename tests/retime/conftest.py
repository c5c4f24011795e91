"""Let our own module import toppra first: it silences warnings about toppra's docstrings."""

import planning.retime.toppra.toppra_passes  # noqa: F401 - for what importing it does
