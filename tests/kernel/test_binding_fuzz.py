"""No argument makes the native module read or write what is not its own: what is wrong raises.

`make sanitize` runs this with addresses checked, where one number out of range that is used ends
the process.
"""

import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.kernel.native import native
from tests.kernel.binding_calls import calls, distance_query, exported, group, prover, scene
from tests.kernel.call_rules import (
    EXACT,
    FINITE,
    INDEX,
    INDICES,
    KIND,
    ROWS,
    SCALAR,
    SIZING,
    Call,
)
from tests.profiles import num_cases

REFUSALS = (IndexError, TypeError, ValueError)
FAR = (-(2**63), -(2**31) - 1, -2, 10**6, 2**31, 2**32, 2**63 - 1)
NAMES = sorted(calls()) if native() else ["none"]
WILD = st.one_of(
    st.sampled_from([None, "", "text", [], (), 0, -1, 1.5, float("nan"), float("inf"), 2**70]),
    st.sampled_from(FAR),
    st.lists(st.floats(), max_size=4),
)


def test_everything_that_is_exported_has_a_valid_call() -> None:
    made = calls()
    assert set(made) == exported()
    for each in made.values():
        each()


@pytest.mark.parametrize("name", NAMES)
def test_what_breaks_a_rule_raises_and_names_the_argument(name: str) -> None:
    for argument, rule in calls()[name].rules.items():
        for wrong in _breaking(rule, argument, calls()[name].arguments[argument]):
            with pytest.raises(REFUSALS) as refusal:
                calls()[name](**{argument: wrong})
            told = str(refusal.value)
            named = argument.partition("_")[0] in told or rule == SIZING
            assert refusal.type is TypeError or named, told


def _breaking(rule: int, name: str, right: Any) -> Iterator[Any]:
    """Yield values that break an argument's rule."""
    if rule == INDEX:
        yield from FAR
    elif rule == SCALAR:
        yield from (np.nan, np.inf, -np.inf, None, "text")
    elif rule == KIND:
        yield from (0, 1, -1, 99, None, "box")
    elif rule == INDICES:
        for far in FAR:
            yield _with(right, far)
        yield from ([[0, 1]], None) if isinstance(right, list) else (right[None], right[:, None])
    elif rule in {EXACT, ROWS, SIZING}:
        yield from _misshapen(rule, right)
        if name in FINITE and right.size:
            yield _with(right, np.nan)


def _misshapen(rule: int, right: np.ndarray) -> Iterator[Any]:
    yield from (right[None], right[..., None], right.ravel()[:0].reshape(*right.shape[:-1], 0))
    yield from (np.concatenate([right, right], axis=-1), right.astype(str), None)
    if rule == EXACT:
        yield from (right[:-1], np.concatenate([right, right[-1:]]))


def _with(right: Any, entry: Any) -> Any:
    """Return the array or list with its last entry replaced."""
    if isinstance(right, list):
        return [*right[:-1], entry]
    wrong = right.copy()
    wrong.reshape(-1)[-1] = entry
    return wrong


@settings(max_examples=num_cases(150))
@given(name=st.sampled_from(NAMES), seed=st.integers(0, 2**32 - 1), data=st.data())
def test_wild_arguments_are_taken_or_refused(name: str, seed: int, data: st.DataObject) -> None:
    """Several at once, in any combination: an answer or an exception, never a fault."""
    each, rng = calls()[name], np.random.default_rng(seed)
    count = int(rng.integers(1, len(each.arguments) + 1)) if each.arguments else 0
    some = rng.permutation(list(each.arguments))[:count].tolist()
    changes = {}
    for argument in some:
        right = each.arguments[argument]
        if argument == "interrupt":
            changes[argument] = data.draw(st.sampled_from([_raising, None, 3]))
        elif isinstance(right, np.ndarray):
            changes[argument] = _distorted(right, rng)
        elif argument not in {"num_positions", "num_velocities", "max_iterations", "max_steps"}:
            changes[argument] = data.draw(WILD)
    _attempt(each, changes)


def _attempt(each: Call, changes: dict[str, Any]) -> None:
    try:
        each(**changes)
    except (*REFUSALS, _Raised):
        pass


class _Raised(Exception):
    pass


def _raising() -> None:
    raise _Raised


def _distorted(right: np.ndarray, rng: np.random.Generator) -> Any:
    """Return the array in another shape, type or layout, or with other entries."""
    wrong = right.copy()
    if wrong.size:
        entries = [np.nan, np.inf, -1e300, 0.0, 1e-300] if wrong.dtype.kind == "f" else FAR
        wrong.reshape(-1)[int(rng.integers(wrong.size))] = rng.choice(np.array(entries))
    options = [
        lambda: wrong,
        lambda: right[: int(rng.integers(len(right) + 1))] if right.ndim else right,
        lambda: np.concatenate([right, right]),
        lambda: right[..., :0],
        lambda: right[None],
        lambda: right.reshape(-1),
        lambda: right.astype(np.float32),
        lambda: right.astype(np.int8),
        lambda: right.astype(complex),
        lambda: right.astype(object),
        lambda: np.repeat(right, 2, axis=-1)[..., ::2],
        lambda: right[::-1],
        lambda: np.asfortranarray(right),
        lambda: np.array(1.0),
        lambda: np.zeros((0,) * max(right.ndim, 1)),
        lambda: rng.normal(size=right.shape),
        right.tolist,
    ]
    return options[int(rng.integers(len(options)))]()


def test_inverse_kinematics_without_seeds_is_refused() -> None:
    with pytest.raises(ValueError, match="seeds has no rows"):
        calls()["Chain.solve"](seeds=np.zeros((0, 11)), target_of=np.zeros(0, np.int64))


def test_an_index_that_would_fit_once_it_is_cut_to_32_bits_is_refused() -> None:
    with pytest.raises(IndexError, match="rows is 4294967296, not an index from 0 to 6"):
        scene().add_pairs(np.array([0, 2**32]))


@pytest.mark.parametrize("positions", [[1, 2], [2, 3], [0, 0], [0, 1, 2], [3], [1, 3, 2]])
def test_a_part_of_a_joint_is_no_group(positions: list[int]) -> None:
    module: Any = native()
    arguments = {name: value for name, (value, _) in group(floats=False).items()}
    arguments |= {"positions": np.array(positions), "velocities": np.array(positions)}
    with pytest.raises(ValueError, match="positions"):
        module.DistanceQuery(**arguments)


def test_a_moving_geometry_without_spheres_is_refused() -> None:
    """It would be free everywhere."""
    with pytest.raises(ValueError, match="outer has no rows"):
        calls()["Scene.add_geometry"](outer=np.zeros((0, 4)))


@pytest.mark.parametrize("made", [prover, distance_query])
def test_a_scene_in_use_does_not_grow(made: Any) -> None:
    """Checkers and provers have tables of its links, geometries and pairs; copies may change."""
    module: Any = native()
    arguments = {name: value for name, (value, _) in group(floats=True).items()}
    module.DistanceQuery(**arguments)
    with pytest.raises(ValueError, match="in use"):
        arguments["scene"].add_pair(0, 1)
    arguments["scene"].with_poses(np.zeros(0, np.int64), np.zeros((0, 12))).add_pair(0, 1)


def test_a_prover_is_used_by_one_call_at_a_time() -> None:
    each = prover(
        0.19999
    )  # of which it takes many segments to prove that a distance of 0.2 keeps it
    refusals: list[str] = []

    def interrupt() -> None:
        for again in (lambda: each.prove(int), lambda: each.bounds([0])):
            thread = threading.Thread(target=_note_refusal, args=(again, refusals))
            thread.start()
            thread.join()

    each.prove(interrupt)
    assert set(refusals) == {"the prover is in use by another call"}
    each.prove(int)


def _note_refusal(again: Any, refusals: list[str]) -> None:
    try:
        again()
    except RuntimeError as refusal:
        refusals.append(str(refusal))
