"""A module that makes the first forkserver that imports it bad: only its first child lives."""

import os
from pathlib import Path

_MARK = Path(os.environ["BAD_FORKSERVER"])
_forked: list[bool] = []


def _end():
    if _forked:
        os._exit(9)


try:
    _MARK.touch(exist_ok=False)
except FileExistsError:
    pass  # this one is good
else:
    os.register_at_fork(after_in_parent=lambda: _forked.append(True), after_in_child=_end)
