"""Valid calls of what shortens paths in the native module."""

from typing import Any

import numpy as np

from planning.kernel.native import native
from tests.kernel.call_rules import ANY, OBJECT, ROWS, SCALAR, SIZING, Call, call


def shortcut_calls(checker: Any) -> dict[str, Call]:
    """Return them for a checker of four coordinates."""
    module: Any = native()

    def are_free(q0s: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.ones(len(q0s), dtype=bool)

    def made() -> Any:
        return module.CheckedEdges(checker, 4, 0.1, lambda: None, are_free, lambda *_: 0)

    path = np.cumsum(np.eye(4), axis=0)
    edges, is_over = (made(), OBJECT), (lambda: False, OBJECT)
    return {
        "CheckedEdges": call(
            module.CheckedEdges, checker=(checker, OBJECT), num_positions=(4, ANY),
            resolution=(0.1, SCALAR), look=(lambda: None, OBJECT), are_free=(are_free, OBJECT),
            first_free=(lambda *_: 0, OBJECT),
        ),
        "skip_vertices": call(
            module.skip_vertices, edges=edges, waypoints=(path, ROWS), is_over=is_over
        ),
        "tighten": call(
            module.tighten, edges=edges, waypoints=(path, ROWS), max_parts=(4, ANY)
        ),
        "relax_path": call(
            module.relax_path, edges=edges, waypoints=(path, ROWS), max_sweeps=(3, ANY),
            min_gain=(0.01, SCALAR), first_whole_fraction=(0.5, SCALAR),
            max_whole_fraction=(0.8, SCALAR), growth=(2.0, SCALAR), shrinkage=(0.4, SCALAR),
            is_over=is_over,
        ),
        "backtrack": call(
            module.backtrack, edges=edges, waypoints=(path, SIZING), free_path=(path, SIZING),
            first_fraction=(0.1, SCALAR), growth=(2.0, SCALAR), max_fraction=(0.75, SCALAR),
        ),
        "cut_corners": call(
            module.cut_corners, edges=edges, waypoints=(path, ROWS),
            fractions=(np.array([0.5, 0.25]), ANY), min_gain=(0.01, SCALAR),
        ),
    }  # fmt: skip
