"""Workers: what their processes import before they run anything. Light: no web, no Drake."""

import importlib
from collections.abc import Mapping, Sequence

from service.jobs.worker.forkserver import start_forkserver

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
    "service.executions.proofs.proof",
    "service.executions.proofs.together_proof",
    "service.executions.proofs.beside_proof",
    "service.executions.proofs.recheck",
    "service.executions.proofs.splice",
    "service.executions.gripping.worker",
    "service.executions.watching.touch_worker",
    "service.executions.replay_worker",
    "service.queries.worker",
    "service.queries.geometry_worker",
    "service.regions.worker",
    "service.scenes.worker",
    "service.plans.delivery.worker",
    "service.plans.delivery.failure_worker",
    "service.plans.delivery.picture_worker",
    "service.plans.warm_up",
)
# What the server needs of that as well: models, numpy, and no Drake.
COMMON = (
    "service.jobs.worker.main",
    "service.catalog.tasks",
    "service.executions.tasks",
    "service.executions.proofs.tasks",
    "service.executions.watching.tasks",
    "service.plans.tasks",
    "service.queries.tasks",
    "service.regions.tasks",
    "service.trajectories.tasks",
    "yaml",
)
WARM_UP = "warm_up"


def import_tasks() -> None:
    """Have this process carry tasks out itself."""
    for name in PRELOAD:
        if name.startswith("service."):
            importlib.import_module(name)


def start_to_import() -> None:
    """Have the forkserver import while this process imports the web: both take seconds.

    It has no effect once the forkserver runs.
    """
    start_forkserver(PRELOAD, COMMON)


def serves_with_processes(arguments: Sequence[str], environment: Mapping[str, str]) -> bool:
    """Return whether a command line serves, with workers that are processes of this machine.

    That can be said before there are settings, which take a third of a second. Where it is wrong,
    `serve` starts the forkserver itself, or has one that nothing is forked off.

    Args:
        arguments: Of the command `wayproof`.
        environment: With settings.
    """
    if arguments[:1] != ["serve"] or "--help" in arguments:
        return False
    engine = environment.get("WAYPROOF_ENGINE", "process")
    for argument, following in zip(arguments, [*arguments[1:], ""], strict=True):
        if argument == "--engine":
            engine = following
        elif argument.startswith("--engine="):
            engine = argument.partition("=")[2]
    return engine == "process"
