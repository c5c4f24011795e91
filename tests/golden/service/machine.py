"""machine(): what the last digits of numbers depend on; alike(): what is the same but for them.

BLAS, numpy and the kernel choose their instructions by the processor: sums come in another order.
An optimisation that ends within a tolerance makes of the last digit of a sum the fifth of a number.
"""

import os
import platform
import re
from pathlib import Path
from typing import Any

import planning
from tests.golden.service.summary import shape

_CPU = Path("/proc/cpuinfo")
_TOLD = ("vendor_id", "cpu family", "model name")
_FLAGS = ("avx", "avx2", "fma", "avx512f", "avx512dq", "avx512vl", "avx512bw")
_NUMBER = re.compile(r"-?\d+(\.\d+)?(e-?\d+)?")
# Between numbers of two machines, of the larger one and in their unit.
_SHARE = 0.01
_ABSOLUTE = 1e-3


def machine() -> str:
    """Return a text that is the same where numbers are."""
    lines = _CPU.read_text(encoding="utf-8").splitlines() if _CPU.exists() else []
    told = dict(line.replace("\t", "").split(":", 1) for line in lines if ":" in line)
    flags = [flag for flag in _FLAGS if flag in told.get("flags", "").split()]
    parts = [platform.machine(), *(told.get(name, "").strip() for name in _TOLD), *flags]
    return " ".join([*parts, planning.kernel_name(), os.environ.get("OPENBLAS_CORETYPE", "")])


def reconciled(old: Any, new: Any) -> Any:
    """Return `new` with what is `old` but for the last digits of numbers as `old` has it."""
    if isinstance(old, dict) and isinstance(new, dict):
        if "<digest>" in old and old.get("made_of") == new.get("made_of"):
            return old
        return {
            key: _member(key, old[key], inner) if key in old else inner
            for key, inner in new.items()
        }
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return [reconciled(before, after) for before, after in zip(old, new, strict=True)]
    return old if alike(old, new) else new


def _member(key: str, old: Any, new: Any) -> Any:
    # Of bodies with parallel faces, many pairs of points are the nearest.
    if key == "points" and shape(old) == shape(new):
        return old
    return reconciled(old, new)


def alike(old: Any, new: Any) -> bool:
    """Return whether two values differ in the last digits of numbers at most."""
    if isinstance(old, float) and isinstance(new, float):
        return abs(old - new) <= max(_ABSOLUTE, _SHARE * max(abs(old), abs(new)))
    if isinstance(old, str) and isinstance(new, str):
        return _NUMBER.sub("#", old) == _NUMBER.sub("#", new)
    return bool(old == new) and type(old) is type(new)
