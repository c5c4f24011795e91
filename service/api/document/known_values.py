"""Values of texts in answers, each list in one place: the document names them (`OneOf`).

What gives them is often out of reach of the service; tests hold the lists against it.
"""

from typing import Annotated

from service.api.document.open_enums import STAGES, Matching, OneOf
from service.jobs.states import JobEvent, JobState

# Names of checks of a certificate; a frame, a zone, a joint or a constraint is named behind others.
CHECKS = (
    "form",
    "start",
    "goal",
    "rest",
    "continuity",
    "velocity continuity",
    "acceleration continuity",
    "position",
    "velocity",
    "acceleration",
    "jerk",
    "torque",
    "line",
    "line rotation",
    "clearance",
    "stop",
)
NAMED_CHECKS = (
    "tool_speed",
    "tool_acceleration",
    "speed_zone",
    "steering",
    r"constraint \d+:",
    r"drake term \d+:",
)
CheckName = Annotated[str, Matching(CHECKS, NAMED_CHECKS)]
# Of executions, beside those: what ends one where no check of a certificate does.
VERDICTS = ("undecided", "request", "beside")
VerdictCheck = Annotated[str, Matching((*CHECKS, *VERDICTS), NAMED_CHECKS)]

UNITS = ("1", "rad or m", "rad/s or m/s", "rad", "m", "m/s", "m/s^2", "s", "faults")
CheckUnit = Annotated[str, OneOf("CheckUnit", "Units of checks.", UNITS)]

# Stages by their names in `timings`; these two are parts of the search.
CUTS = (*STAGES, "shortcut", "interpolate")
CutStage = Annotated[str, OneOf("CutStage", "Stages that a deadline may cut short.", CUTS)]

# Those with a blank are OMPL's.
OUTCOMES = (
    "solved",
    "collides",
    "setup",
    "improving",
    "Approximate solution",
    "Exact solution",
    "Timeout",
    "Invalid start",
    "Invalid goal",
    "Unrecognized goal type",
    "Crash",
    "Unknown status",
)
AttemptOutcome = Annotated[str, OneOf("AttemptOutcome", "Outcomes of a search's tries.", OUTCOMES)]

METHODS = ("toppra", "ruckig")
RetimingMethod = Annotated[str, OneOf("RetimingMethod", "Methods of timing.", METHODS)]

SOLVERS = ("interior point", "Clarabel", "SNOPT", "")
RefineSolver = Annotated[str, OneOf("RefineSolver", "Solvers of refinement, or none.", SOLVERS)]

EXECUTION_STATES = (
    "accepted",
    "executing",
    "paused",
    "canceling",
    "aborting",
    "succeeded",
    "canceled",
    "aborted",
)
EXECUTION_EVENTS = (
    "start",
    "pause",
    "resume",
    "set_speed",
    "cancel",
    "succeed",
    "stopped",
    "fail",
    "lose",
)
JOB_STATES = tuple(state.value for state in JobState)
JOB_EVENTS = tuple(event.value for event in JobEvent)
STATES = tuple(dict.fromkeys((*JOB_STATES, *EXECUTION_STATES, "at its end")))
EVENTS = tuple(dict.fromkeys((*JOB_EVENTS, *EXECUTION_EVENTS, "steer", "delete")))
RefusingState = Annotated[
    str, OneOf("RefusingState", "States of jobs and executions that refuse an event.", STATES)
]
RefusedEvent = Annotated[str, OneOf("RefusedEvent", "Events of jobs and executions.", EVENTS)]
# `unmoved` is a scene in which nothing was carried out.
MotionlessState = Annotated[
    str,
    OneOf("MotionlessState", "States of what has no motion to give.", (*JOB_STATES, "unmoved")),
]

QUEUES = ("plan", "query", "execution", "regions")
QueueName = Annotated[str, OneOf("QueueName", "Queues of jobs and questions.", QUEUES)]

SCOPES = ("read", "plan", "execute", "admin")
ScopeName = Annotated[str, OneOf("ScopeName", "Scopes of keys.", SCOPES)]

RESOURCES = ("batch", "job", "mesh", "plan", "execution", "regions", "revision", "scene", "webhook")
# A robot is no resource of its own, but has an address.
ResourceKind = Annotated[
    str, OneOf("ResourceKind", "Kinds of resources that may not exist.", (*RESOURCES, "robot"))
]

NAMES = (
    "body",
    "configuration",
    "controller",
    "derivative",
    "frame",
    "group",
    "joint",
    "joint or block",
    "link",
    "object",
    "parameter",
    "part",
    "planar joint",
    "planar or floating joint",
    "planner",
    "position",
    "query parameter",
    "robot",
    "scene robot",
    "space",
)
NameKind = Annotated[str, OneOf("NameKind", "Kinds of names that may not exist.", NAMES)]
