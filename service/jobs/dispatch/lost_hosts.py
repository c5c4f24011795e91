"""What becomes of a job whose machine was lost."""

from service.jobs.job import Job
from service.jobs.outcome import Crashed, Failed, Lost, Silent

# A job is run no more once this number of machines was lost under it.
MAX_LOST_HOSTS = 3


def runs_elsewhere(outcome: Lost, job: Job, num_lost_hosts: int) -> bool:
    """Return whether a job is queued again, which is no attempt of its own.

    One that had not begun there may always run elsewhere; one that takes machine after machine
    with it may not.

    Args:
        outcome: Of its run.
        job: Which one.
        num_lost_hosts: How many machines were lost under it, this one included.
    """
    return not outcome.has_begun or (job.max_attempts > 1 and num_lost_hosts < MAX_LOST_HOSTS)


def is_mere_cancel(outcome: Failed, job: Job) -> bool:
    """Return whether the end of the process of a canceled job is what was asked for.

    What may run but once is not known to have come to rest.
    """
    if isinstance(outcome, Lost) and not outcome.has_begun:
        return True
    return job.max_attempts > 1 and isinstance(outcome, Crashed | Silent | Lost)
