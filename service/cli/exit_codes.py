"""Exit codes of the command line, by which scripts tell what happened."""

from enum import IntEnum


class ExitCode(IntEnum):
    """What a command ends with; after Ctrl-C it is 130."""

    SUCCESS = 0
    # No plan was found, an execution was aborted, a configuration collides, a server cannot start.
    NO_RESULT = 1
    # An option, a name, a file or a setting is wrong.
    USAGE = 2
    # Another server took the database over.
    TAKEN = 3
    # The server refused: its problem is on stderr.
    REFUSED = 4
    # The server cannot be reached, or the private one did not start.
    UNREACHABLE = 5


EPILOG = (
    "Exit codes: 0 done; 1 no result (no plan, aborted, in collision); "
    "2 a wrong option, name or file; 3 another server took the database; 4 the server refused; "
    "5 no server; 130 interrupted."
)
