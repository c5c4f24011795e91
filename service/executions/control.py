"""Steering: what is asked of an execution that runs."""

from pathlib import Path

from planning.errors import IllegalTransition
from service.executions.controls import Controls, read_controls
from service.jobs.records import Job


def steer(job: Job, *, is_paused: bool | None = None, speed: float | None = None) -> None:
    """Ask an execution to rest, to move on, or to move at another speed.

    Raises:
        IllegalTransition: It has ended or is to end.
    """
    if job.state.is_final or job.is_cancel_requested:
        state = job.state if job.state.is_final else "canceling"
        message = f"execution {job.id} is {state}: it cannot be steered any more"
        raise IllegalTransition(message, {"state": state, "event": "steer", "legal": []})
    path = Path(job.payload["controls"])
    asked = read_controls(path, job.payload["speed"])
    Controls(
        is_paused=asked.is_paused if is_paused is None else is_paused,
        speed=asked.speed if speed is None else speed,
    ).write(path)
