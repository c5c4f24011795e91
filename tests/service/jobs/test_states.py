"""The state machine over the full product of states and events."""

import pytest

from planning.errors import IllegalTransition
from service.jobs.states import TRANSITIONS, JobEvent, JobState, advance


@pytest.mark.parametrize("state", JobState)
@pytest.mark.parametrize("event", JobEvent)
def test_every_pair_is_in_the_table_or_refused(state: JobState, event: JobEvent) -> None:
    if (state, event) in TRANSITIONS:
        assert advance(state, event) is TRANSITIONS[state, event]
    else:
        with pytest.raises(IllegalTransition) as refusal:
            advance(state, event)
        legal = {e for s, e in TRANSITIONS if s is state}
        assert set(refusal.value.evidence["legal"]) == legal


def test_nothing_leaves_a_final_state_and_everything_reaches_one() -> None:
    assert not any(state.is_final for state, _ in TRANSITIONS)
    reached = {JobState.QUEUED}
    for _ in JobState:
        reached |= {after for (before, _), after in TRANSITIONS.items() if before in reached}
    assert reached == set(JobState)


@pytest.mark.parametrize("event", JobEvent)
def test_an_event_leads_to_one_state_wherever_it_happens(event: JobEvent) -> None:
    assert len({after for (_, e), after in TRANSITIONS.items() if e is event}) == 1
