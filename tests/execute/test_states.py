"""The state table, over the full product of states and events."""

import pickle
from itertools import product

import pytest

from planning.errors import IllegalTransition
from planning.execute.states import ExecutionEvent, ExecutionState, advance, legal_events

# Written out once more, by hand: a row per state, a column per event, "." where it is illegal.
GRID = """
           start      pause   resume     set_speed  cancel     succeed    stopped  fail      lose
accepted   executing  .       .          accepted   canceling  .          .        aborted   aborted
executing  .          paused  executing  executing  canceling  succeeded  .        aborting  aborted
paused     .          paused  executing  paused     canceling  .          .        aborting  aborted
canceling  .          .       .          .          canceling  .          canceled aborting  aborted
aborting   .          .       .          .          aborting   .          aborted  aborting  aborted
succeeded  .          .       .          .          .          .          .        .         .
canceled   .          .       .          .          .          .          .        .         .
aborted    .          .       .          .          .          .          .        .         .
"""
HEAD, *ROWS = [line.split() for line in GRID.strip().splitlines()]
EXPECTED = {(row[0], event): to for row in ROWS for event, to in zip(HEAD, row[1:], strict=True)}


def test_the_grid_is_the_full_product() -> None:
    assert set(EXPECTED) == {(str(s), str(e)) for s, e in product(ExecutionState, ExecutionEvent)}


@pytest.mark.parametrize("event", ExecutionEvent)
@pytest.mark.parametrize("state", ExecutionState)
def test_every_state_and_event(state: ExecutionState, event: ExecutionEvent) -> None:
    expected = EXPECTED[str(state), str(event)]
    if expected != ".":
        assert advance(state, event) == expected
        return
    with pytest.raises(IllegalTransition) as caught:
        advance(state, event)
    legal = [e for e in map(str, ExecutionEvent) if EXPECTED[str(state), e] != "."]
    assert caught.value.evidence == {"state": str(state), "event": str(event), "legal": legal}
    assert pickle.loads(pickle.dumps(caught.value)).detail == caught.value.detail


def test_only_terminal_states_allow_nothing_and_all_others_can_end() -> None:
    terminal = {state for state in ExecutionState if state.is_terminal}
    assert terminal == {"succeeded", "canceled", "aborted"}
    for state in set(ExecutionState) - terminal:
        assert advance(state, ExecutionEvent.LOSE) is ExecutionState.ABORTED
        assert advance(state, ExecutionEvent.FAIL) in {"aborting", "aborted"}
        assert ExecutionEvent.CANCEL in legal_events(state)
