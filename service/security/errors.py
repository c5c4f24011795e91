"""What is wrong with keys, and with how a server is started."""

from planning.errors import WayproofError


class KeyExists(WayproofError):
    """A key of this name is in use; evidence: `name`."""

    code = "key_exists"


class Unguarded(WayproofError):
    """The server would listen beyond this machine, and ask for no keys; evidence: `host`."""

    code = "unguarded"
