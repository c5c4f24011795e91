"""Leash: a process dies when it should, even inside native code that holds the interpreter.

Neither a Python signal handler nor a thread can run then; default actions of signals can. The
parent holds the write end of a pipe. When the parent dies, however it dies, the kernel closes that
end and sends SIGIO to the owner of the read end, whose default action is to end the process
(fcntl(2): O_ASYNC, F_SETOWN). `PR_SET_PDEATHSIG` does not work here: under a forkserver, the
parent is the forkserver.
"""

import fcntl
import os
import signal
from multiprocessing.connection import Connection


def exit_with_parent(parent: Connection) -> None:
    """Make this process end by SIGTERM at once, and when the other end of `lifeline` closes."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server decides what an interrupt ends
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGIO, signal.SIGTERM})
    descriptor = parent.fileno()
    fcntl.fcntl(descriptor, fcntl.F_SETOWN, os.getpid())
    flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
    fcntl.fcntl(descriptor, fcntl.F_SETFL, flags | os.O_ASYNC | os.O_NONBLOCK)
    if parent.poll(0):  # closed before we listened
        os._exit(1)
