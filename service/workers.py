"""Workers: what their processes import before they run anything. Light: no web, no Drake."""

import importlib
import multiprocessing.forkserver

from service.jobs.worker.process import forkserver

# What the forkserver imports once, so that every worker has Drake and OMPL from its birth.
# What draws is left out: matplotlib takes a second, and few ask for a plot.
PRELOAD = (
    "planning.kernel._native",
    "service.executions.worker",
    "service.catalog.worker",
    "service.trajectories.worker",
    "service.trajectories.transition_worker",
    "service.trajectories.schedule_worker",
    "service.plans.worker",
    "service.executions.proof",
    "service.executions.recheck",
    "service.executions.splice",
    "service.executions.replay_worker",
    "service.queries.worker",
    "service.queries.geometry_worker",
    "service.regions.worker",
    "service.scenes.worker",
    "service.plans.output_worker",
    "service.plans.warm_up",
)
WARM_UP = "warm_up"


def import_tasks() -> None:
    """Have this process carry tasks out itself."""
    for name in PRELOAD:
        if name.startswith("service."):
            importlib.import_module(name)


def start_to_import() -> None:
    """Have the forkserver import while this process imports the web: both take seconds."""
    forkserver(PRELOAD)
    multiprocessing.forkserver.ensure_running()
