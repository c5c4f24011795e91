"""ExecutionState: the state machine of an execution, as a transition table.

The states are those of a ROS 2 action goal (design.ros2.org/articles/actions.html), and two more,
which a ROS 2 client should see as executing: `paused` can be resumed and never succeeds; `aborting`
has failed, and the robot is not at rest yet.

    accepted --start--> executing --succeed--> succeeded
        |                |  ^   |
        |          pause |  | resume
        |                v  |
        |               paused
        |                  |
        +-----cancel-------+---> canceling --stopped--> canceled
    executing, paused, canceling --fail--> aborting --stopped--> aborted
    accepted --fail--> aborted; any of these --lose--> aborted
    accepted, executing, paused --set_speed--> themselves

Pause, resume and cancel are idempotent, so a client may repeat a request. Beyond ROS 2, `accepted`
may abort: the robot may be elsewhere than at the start. A motion that happens to reach its goal
while it is being canceled ends as `canceled`, as requested. One that fails ends as `aborted`,
whatever is asked of it then.
"""

from enum import StrEnum

from planning.errors import IllegalTransition


class ExecutionState(StrEnum):
    """State of an execution."""

    ACCEPTED = "accepted"
    EXECUTING = "executing"
    PAUSED = "paused"
    CANCELING = "canceling"
    ABORTING = "aborting"
    SUCCEEDED = "succeeded"
    CANCELED = "canceled"
    ABORTED = "aborted"

    @property
    def is_terminal(self) -> bool:
        """Whether the state allows no further event."""
        return not legal_events(self)


class ExecutionEvent(StrEnum):
    """Event of an execution; the first five are commands, the others results of measurements.

    `fail` is a failure of the motion, `lose` one after which nothing can be sent to the robot.
    """

    START = "start"
    PAUSE = "pause"
    RESUME = "resume"
    SET_SPEED = "set_speed"
    CANCEL = "cancel"
    SUCCEED = "succeed"
    STOPPED = "stopped"
    FAIL = "fail"
    LOSE = "lose"


_S, _E = ExecutionState, ExecutionEvent

TRANSITIONS: dict[tuple[ExecutionState, ExecutionEvent], ExecutionState] = {
    (_S.ACCEPTED, _E.START): _S.EXECUTING,
    (_S.ACCEPTED, _E.SET_SPEED): _S.ACCEPTED,
    (_S.ACCEPTED, _E.CANCEL): _S.CANCELING,
    (_S.ACCEPTED, _E.FAIL): _S.ABORTED,
    (_S.ACCEPTED, _E.LOSE): _S.ABORTED,
    (_S.EXECUTING, _E.PAUSE): _S.PAUSED,
    (_S.EXECUTING, _E.RESUME): _S.EXECUTING,
    (_S.EXECUTING, _E.SET_SPEED): _S.EXECUTING,
    (_S.EXECUTING, _E.CANCEL): _S.CANCELING,
    (_S.EXECUTING, _E.SUCCEED): _S.SUCCEEDED,
    (_S.EXECUTING, _E.FAIL): _S.ABORTING,
    (_S.EXECUTING, _E.LOSE): _S.ABORTED,
    (_S.PAUSED, _E.PAUSE): _S.PAUSED,
    (_S.PAUSED, _E.RESUME): _S.EXECUTING,
    (_S.PAUSED, _E.SET_SPEED): _S.PAUSED,
    (_S.PAUSED, _E.CANCEL): _S.CANCELING,
    (_S.PAUSED, _E.FAIL): _S.ABORTING,
    (_S.PAUSED, _E.LOSE): _S.ABORTED,
    (_S.CANCELING, _E.CANCEL): _S.CANCELING,
    (_S.CANCELING, _E.STOPPED): _S.CANCELED,
    (_S.CANCELING, _E.FAIL): _S.ABORTING,
    (_S.CANCELING, _E.LOSE): _S.ABORTED,
    (_S.ABORTING, _E.CANCEL): _S.ABORTING,
    (_S.ABORTING, _E.STOPPED): _S.ABORTED,
    (_S.ABORTING, _E.FAIL): _S.ABORTING,
    (_S.ABORTING, _E.LOSE): _S.ABORTED,
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
