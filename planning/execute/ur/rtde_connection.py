"""RtdeConnection: a connection to a controller's RTDE port, with one recipe each way."""

import select
import socket
import struct
from collections.abc import Mapping, Sequence

from planning.execute.ur.rtde_package import (
    PROTOCOL_VERSION,
    FieldValue,
    PackageReader,
    PackageType,
    Recipe,
    encode,
)

_CHUNK = 65536


class RtdeConnection:
    """Connection that receives fields at a frequency and sends fields at will.

    Every method raises ConnectionError if the connection is broken or silent for too long, and
    ValueError if what comes is not what the protocol says.
    """

    def __init__(self, host: str, port: int, timeout: float) -> None:
        """Connect.

        Args:
            host: Name or address of the controller.
            port: Its RTDE port.
            timeout: Longest silence [s].
        """
        try:
            self._socket = socket.create_connection((host, port), timeout=timeout)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except OSError as fault:
            message = f"cannot connect to {host}:{port}: {fault}"
            raise ConnectionError(message) from fault
        self._reader = PackageReader()
        self._outputs = self._inputs = Recipe(0, (), ())

    def set_up(self, frequency: float, outputs: Sequence[str], inputs: Sequence[str]) -> None:
        """Agree on version and recipes, and have data sent at a frequency [Hz]."""
        version = struct.pack(">H", PROTOCOL_VERSION)
        self._require(PackageType.REQUEST_PROTOCOL_VERSION, version)
        wanted = struct.pack(">d", frequency) + ",".join(outputs).encode("ascii")
        self._outputs = Recipe.agreed(outputs, self._ask(PackageType.SETUP_OUTPUTS, wanted))
        written = ",".join(inputs).encode("ascii")
        self._inputs = Recipe.agreed(inputs, self._ask(PackageType.SETUP_INPUTS, written))
        self._require(PackageType.START, b"")

    def send(self, values: Mapping[str, FieldValue]) -> None:
        """Send a value for each input field."""
        if not self._inputs.names:
            message = "no fields are agreed on"
            raise ValueError(message)
        self._send(self._inputs.pack(values))

    def receive(self) -> dict[str, FieldValue]:
        """Wait for the next data package and return its values."""
        while True:
            kind, content = self._next()
            if kind == PackageType.DATA:
                return self._outputs.unpack(content)

    def has_more(self) -> bool:
        """Return whether more has come already than what was received."""
        return len(self._reader.buffer) > 0 or bool(select.select([self._socket], [], [], 0)[0])

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _require(self, kind: PackageType, content: bytes) -> None:
        if self._ask(kind, content) != b"\x01":
            message = f"the controller refused {kind.name}"
            raise ValueError(message)

    def _ask(self, kind: PackageType, content: bytes) -> bytes:
        self._send(encode(kind, content))
        while True:
            answered, answer = self._next()
            if answered == kind:
                return answer

    def _send(self, package: bytes) -> None:
        try:
            self._socket.sendall(package)
        except OSError as fault:
            message = f"the connection broke: {fault}"
            raise ConnectionError(message) from fault

    def _next(self) -> tuple[int, bytes]:
        while (package := self._reader.next()) is None:
            try:
                received = self._socket.recv(_CHUNK)
            except TimeoutError as fault:
                message = "the controller is silent"
                raise ConnectionError(message) from fault
            except OSError as fault:
                message = f"the connection broke: {fault}"
                raise ConnectionError(message) from fault
            if not received:
                message = "the controller closed the connection"
                raise ConnectionError(message)
            self._reader.feed(received)
        return package
