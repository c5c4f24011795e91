"""leave_network(): a worker goes on without any network but a loopback interface of its own.

What parses files from outside may be made to run what is in them; it is to reach nothing then. A
network namespace (network_namespaces(7)) is of the process and its children, and nothing of it can
be given back. Sockets that are open stay: those to the server are.
"""

import fcntl
import os
import socket
import struct
from contextlib import suppress
from pathlib import Path

_SELF = Path("/proc/self")
# netdevice(7): an interface by its name, and its flags.
_SET_FLAGS, _IS_UP = 0x8914, 0x1
_INTERFACE = struct.Struct("16sh14x")


def leave_network() -> str | None:
    """Leave the machine's network; call it before there are threads.

    Returns:
        Why it is still reached, None if it is not.
    """
    user, group = os.geteuid(), os.getegid()
    try:
        try:
            os.unshare(os.CLONE_NEWNET)  # for root
        except PermissionError:
            os.unshare(os.CLONE_NEWUSER | os.CLONE_NEWNET)
            _keep_names(user, group)
        _raise_loopback()
    except (AttributeError, OSError) as fault:  # no such kernel, or it refuses
        return f"network namespaces: {getattr(fault, 'strerror', None) or fault}"
    return None


def _keep_names(user: int, group: int) -> None:
    """Have user and group be called as before, which is all that a user namespace changes."""
    for file, text in (
        ("setgroups", "deny"),
        ("uid_map", f"{user} {user} 1"),
        ("gid_map", f"{group} {group} 1"),
    ):
        with suppress(OSError):
            (_SELF / file).write_text(text, encoding="ascii")


def _raise_loopback() -> None:
    """Let the process reach itself: Drake's replay is written by a server and its client."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        fcntl.ioctl(any_socket, _SET_FLAGS, _INTERFACE.pack(b"lo", _IS_UP))
