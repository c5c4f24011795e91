"""Array: numbers that can be drawn."""

from typing import Any

import numpy as np

type Array = np.ndarray[Any, np.dtype[np.float64]]
