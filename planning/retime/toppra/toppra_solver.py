"""toppra solver: toppra's linear programs, without importing the rest of toppra.

Importing the toppra package imports pyplot, for methods that draw, and scipy, for splines: together
more than half of the start-up time of a planning process. Here both are deferred until an attribute
is used that needs them.
"""

import logging
import sys
import warnings
from importlib.util import find_spec, module_from_spec
from types import ModuleType
from typing import Any, override


class _DeferredModule(ModuleType):
    """A module whose own code runs at the first access to an attribute that is missing."""

    @override
    def __getattr__(self, name: str) -> Any:
        spec = self.__spec__
        # The import system asks for `__path__`, to know whether this is a package.
        if spec is None or spec.loader is None or name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        object.__setattr__(self, "__class__", ModuleType)
        spec.loader.exec_module(self)
        return getattr(self, name)


def _import_lazily(name: str, **preset: Any) -> None:
    """Allow imports from a module without running its own code, unless it already ran.

    Args:
        name: Of the module; its parent is imported or deferred.
        preset: Attributes that may be had before the code runs, which then sets them.
    """
    spec = find_spec(name)
    if name not in sys.modules and spec is not None:
        module = module_from_spec(spec)
        vars(module).update(preset)
        module.__class__ = _DeferredModule
        sys.modules[name] = module
        parent, _, last = name.rpartition(".")
        if parent:
            setattr(sys.modules[parent], last, module)


_import_lazily("toppra")
_import_lazily("toppra.solverwrapper")
# Constraints use this class as a type in annotations, and nothing else of the module.
_import_lazily("toppra.interpolator", AbstractGeometricPath=object)
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from toppra.constraint import ConstraintType, DiscretizationType, LinearConstraint
    from toppra.solverwrapper.cy_seidel_solverwrapper import seidelWrapper

logging.getLogger("toppra").setLevel(logging.CRITICAL)

__all__ = ["ConstraintType", "DiscretizationType", "LinearConstraint", "seidelWrapper"]
