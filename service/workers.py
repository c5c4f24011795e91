"""Workers: what their processes import before they run anything. Light: no web, no Drake."""

import multiprocessing.forkserver

from service.jobs.worker.process import forkserver

# What the forkserver imports once, so that every worker has Drake and OMPL from its birth.
# What draws is left out: matplotlib takes a second, and few ask for a plot.
PRELOAD = (
    "planning.kernel._native",
    "service.tasks.execute",
    "service.tasks.leaving",
    "service.tasks.lines",
    "service.tasks.models",
    "service.tasks.own_motion",
    "service.tasks.plan",
    "service.tasks.planners",
    "service.tasks.proof",
    "service.tasks.queries",
    "service.tasks.regions",
    "service.tasks.reverse",
    "service.tasks.scenes",
    "service.tasks.trajectories",
    "service.tasks.warm",
)
WARM_UP = "service.tasks.warm:warm_up"


def start_to_import() -> None:
    """Have the forkserver import while this process imports the web: both take seconds."""
    forkserver(PRELOAD)
    multiprocessing.forkserver.ensure_running()
