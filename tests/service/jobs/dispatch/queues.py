"""Queues whose workers are places alone: what a queue decides needs no more of one."""

from service.jobs.dispatch.scheduling.queue import JobQueue
from service.jobs.dispatch.scheduling.waiting import QueueEntry
from service.jobs.dispatch.scheduling.worker_pool import WorkerPool


class Seat:
    """Stands for a worker; queues look at nothing else of one."""

    generation = 0


def queue_of(num_workers, *, idle=True, max_waiting=10, **options):
    queue = JobQueue("plan", [Seat() for _ in range(num_workers)], max_waiting, **options)
    if idle:
        for worker in queue.pool.workers:
            queue.pool.give_back(worker)
    return queue


def queues_of(**shares):
    """Queues of one pool that has just as many workers as they may use, all idle."""
    pool = WorkerPool([Seat() for _ in range(sum(share.max_running for share in shares.values()))])
    for worker in pool.workers:
        pool.give_back(worker)
    return [JobQueue(name, pool, 10, share=share) for name, share in shares.items()]


def wait(queue, name, key=None, since=0.0, **options):
    queue.add(QueueEntry(name, queue.next_place(since), lambda _: None, key, **options))


def free(queue, worker, seconds=None, now=0.0):
    """The run in a worker has ended, and the worker is ready again."""
    if seconds is None:
        queue.take_back(worker)
    else:
        queue.end_run(worker, now, seconds)
    queue.pool.give_back(worker)


def names(assignments):
    return [entry.name for entry, _ in assignments.pairs]
