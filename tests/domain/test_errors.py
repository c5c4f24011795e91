"""The error tree: coded once, pickled whole, names the right ones."""

import pickle

import planning.errors as tree
from planning.errors import UnknownName, WayproofError


def _classes(base: type[WayproofError]) -> list[type[WayproofError]]:
    return [base, *(leaf for child in base.__subclasses__() for leaf in _classes(child))]


def test_every_leaf_has_a_code_of_its_own() -> None:
    leaves = [c for c in _classes(WayproofError) if not c.__subclasses__()]
    own = [c for c in leaves if c.__module__ == tree.__name__]
    codes = [c.code for c in own]
    assert len(set(codes)) == len(codes) >= 18
    assert all(code in tree.__doc__ for code in codes)


def test_errors_cross_processes_whole() -> None:
    error = UnknownName.among("frame", "tol0", ["tool0", "world"])
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is UnknownName
    assert (again.detail, again.evidence) == (error.detail, error.evidence)
    assert "did you mean 'tool0'?" in error.detail
    assert "['tool0', 'world']" in error.detail
