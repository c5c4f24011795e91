"""toppra solver: toppra's linear programs, without importing the rest of toppra.

Importing the toppra package imports pyplot, for methods that draw: a third of the start-up time of
a planning process. Here that import is deferred until an attribute is used that needs it.
"""

import logging
import sys
import warnings
from importlib.util import find_spec, module_from_spec
from types import ModuleType
from typing import Any, override


class _DeferredPackage(ModuleType):
    """A package whose own code runs at the first access to an attribute that is missing."""

    @override
    def __getattr__(self, name: str) -> Any:
        spec = self.__spec__
        object.__setattr__(self, "__class__", ModuleType)
        if spec is not None and spec.loader is not None:
            spec.loader.exec_module(self)
        return getattr(self, name)


def _import_lazily(name: str) -> None:
    """Allow imports of submodules without running the package's own code, unless it already ran."""
    spec = find_spec(name)
    if name not in sys.modules and spec is not None:
        package = module_from_spec(spec)
        package.__class__ = _DeferredPackage
        sys.modules[name] = package


_import_lazily("toppra")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from toppra.constraint import ConstraintType, DiscretizationType, LinearConstraint
    from toppra.solverwrapper.cy_seidel_solverwrapper import seidelWrapper

logging.getLogger("toppra").setLevel(logging.CRITICAL)

__all__ = ["ConstraintType", "DiscretizationType", "LinearConstraint", "seidelWrapper"]
