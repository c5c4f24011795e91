"""ExecutionState: the state machine of an execution, as a transition table.

The states are those of a ROS 2 action goal (design.ros2.org/articles/actions.html), and `paused`:
a ROS 2 client should see it as executing. It is a state of its own because its legal events differ:
a paused motion can be resumed, and it never succeeds.

    accepted --start--> executing --succeed--> succeeded
        |                |  ^   |
        |          pause |  | resume
        |                v  |
        |               paused
        |                  |
        +-----cancel-------+---> canceling --stopped--> canceled
    any of these --fail--> aborted; all but canceling --set_speed--> themselves

Pause, resume and cancel are idempotent, so a client may repeat a request. Beyond ROS 2, `accepted`
may abort: the robot may be elsewhere than at the start. A motion that happens to reach its goal
while it is being canceled ends as `canceled`, as requested.
"""

from enum import StrEnum

from planning.errors import IllegalTransition


class ExecutionState(StrEnum):
    """State of an execution."""

    ACCEPTED = "accepted"
    EXECUTING = "executing"
    PAUSED = "paused"
    CANCELING = "canceling"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"

    @property
    def is_terminal(self) -> bool:
        """Whether the state allows no further event."""
        return not legal_events(self)


class ExecutionEvent(StrEnum):
    """Event of an execution; the first five are commands, the others results of measurements."""

    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    SET_SPEED = "set_speed"
    CANCEL = "cancel"
    SUCCEED = "succeed"
    STOPPED = "stopped"
    FAIL = "fail"


_S, _E = ExecutionState, ExecutionEvent

TRANSITIONS: dict[tuple[ExecutionState, ExecutionEvent], ExecutionState] = {
    (_S.ACCEPTED, _E.START): _S.EXECUTING,
    (_S.ACCEPTED, _E.SET_SPEED): _S.ACCEPTED,
    (_S.ACCEPTED, _E.CANCEL): _S.CANCELING,
    (_S.ACCEPTED, _E.FAIL): _S.ABORTED,
    (_S.EXECUTING, _E.PAUSE): _S.PAUSED,
    (_S.EXECUTING, _E.RESUME): _S.EXECUTING,
    (_S.EXECUTING, _E.SET_SPEED): _S.EXECUTING,
    (_S.EXECUTING, _E.CANCEL): _S.CANCELING,
    (_S.EXECUTING, _E.SUCCEED): _S.SUCCEEDED,
    (_S.EXECUTING, _E.FAIL): _S.ABORTED,
    (_S.PAUSED, _E.PAUSE): _S.PAUSED,
    (_S.PAUSED, _E.RESUME): _S.EXECUTING,
    (_S.PAUSED, _E.SET_SPEED): _S.PAUSED,
    (_S.PAUSED, _E.CANCEL): _S.CANCELING,
    (_S.PAUSED, _E.FAIL): _S.ABORTED,
    (_S.CANCELING, _E.CANCEL): _S.CANCELING,
    (_S.CANCELING, _E.STOPPED): _S.CANCELED,
    (_S.CANCELING, _E.FAIL): _S.ABORTED,
}


def legal_events(state: ExecutionState) -> tuple[ExecutionEvent, ...]:
    """Return the events that `state` allows, in the order of `ExecutionEvent`."""
    return tuple(event for event in ExecutionEvent if (state, event) in TRANSITIONS)


def advance(state: ExecutionState, event: ExecutionEvent) -> ExecutionState:
    """Return the state after `event`.

    Raises:
        IllegalTransition: `state` does not allow `event`; the evidence has those that it allows.
    """
    if (state, event) not in TRANSITIONS:
        legal = [str(other) for other in legal_events(state)]
        message = f"an execution that is {state} does not allow {event!s}; it allows {legal}"
        raise IllegalTransition(message, {"state": str(state), "event": str(event), "legal": legal})
    return TRANSITIONS[state, event]
