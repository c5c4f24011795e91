"""Array types: numpy arrays by element type, for annotations that need no shape.

Where the shape is part of the contract, the annotation is jaxtyping's: `Float64[Array, "n nq"]` is
written `Float64[np.ndarray, "n nq"]`, as its documentation has it.
"""

from typing import Any

import numpy as np

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]
type Flags = np.ndarray[Any, np.dtype[np.bool_]]
