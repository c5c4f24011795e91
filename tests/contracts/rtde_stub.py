"""A stand-in for a controller of Universal Robots on loopback: its RTDE port and its script port.

It is written from the protocol's guide, apart from the client: bytes are packed by hand here. Its
clock goes by what comes in: a cycle passes with every data package of the client, so no test
depends on how busy a machine is.
"""

import re
import socket
import struct
import threading
from typing import Any

PERIOD = 0.008
OUTPUTS = {
    "timestamp": ("DOUBLE", "d"),
    "actual_q": ("VECTOR6D", "6d"),
    "actual_qd": ("VECTOR6D", "6d"),
    "safety_mode": ("INT32", "i"),
    "runtime_state": ("UINT32", "I"),
    "output_int_register_24": ("INT32", "i"),
}
INPUTS = {"input_int_register_24": ("INT32", "i")} | {
    f"input_double_register_{i}": ("DOUBLE", "d") for i in range(24, 30)
}


class RtdeStub:
    """A controller whose joints are at the end of each cycle where the servo's target was.

    Attributes:
        program: What came on the script port.
        targets: Every target that was sent while the program ran.
        taken: Input fields that another client writes.
        burst: How many cycles pass with each package of the client.
        cycled: Set once they have passed.
    """

    def __init__(self, q: list[float], timestamp: float = 1234.5) -> None:
        self.q, self.qd = list(q), [0.0] * 6
        self.timestamp = timestamp
        self.program = ""
        self.targets: list[list[float]] = []
        self.taken: set[str] = set()
        self.safety_mode, self.runtime_state, self.running = 1, 1, 0
        self.burst = 1
        self.cycled = threading.Event()
        self.runs_programs = True
        self.version_accepted = 1
        self._lock = threading.Lock()
        self._rtde, self._script = (socket.create_server(("127.0.0.1", 0)) for _ in range(2))
        self._client: socket.socket | None = None
        self._output_names: list[str] = []
        self._input_names: list[str] = []
        self._threads = [
            threading.Thread(target=serve, daemon=True)
            for serve in (self._exchange, self._programs)
        ]
        for thread in self._threads:
            thread.start()

    @property
    def ports(self) -> tuple[int, int]:
        return self._rtde.getsockname()[1], self._script.getsockname()[1]

    def break_connection(self) -> None:
        if self._client is not None:
            self._client.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        for server in (self._rtde, self._script):
            server.shutdown(socket.SHUT_RDWR)
            server.close()
        for thread in self._threads:
            thread.join(timeout=10)

    def _programs(self) -> None:
        while True:
            try:
                client, _ = self._script.accept()
            except OSError:
                return
            with client:
                text = b""
                while part := client.recv(65536):
                    text += part
            self.cycled.wait(60)  # the client sent a target before: it is taken before
            with self._lock:
                self.program = text.decode("ascii")
                if self.runs_programs and re.match(
                    r"def \w+\(\):\n.*end\n$", self.program, re.DOTALL
                ):
                    self.running, self.runtime_state = 1, 2
                self._send_data()

    def _exchange(self) -> None:
        try:
            self._client, _ = self._rtde.accept()
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._client:
                while head := self._exactly(3):
                    size, kind = struct.unpack(">HB", head)
                    self._answer(chr(kind), self._exactly(size - 3))
        except OSError:
            return

    def _exactly(self, count: int) -> bytes:
        assert self._client is not None
        found = b""
        while len(found) < count:
            part = self._client.recv(count - len(found))
            if not part:
                return b""
            found += part
        return found

    def _send(self, kind: str, content: bytes) -> None:
        assert self._client is not None
        self._client.sendall(struct.pack(">HB", 3 + len(content), ord(kind)) + content)

    def _answer(self, kind: str, content: bytes) -> None:
        with self._lock:
            match kind:
                case "V":
                    assert struct.unpack(">H", content) == (2,)
                    self._send("M", b"\x05hello\x04stub\x02")  # a client has to skip messages
                    self._send("V", bytes([self.version_accepted]))
                case "O":
                    assert struct.unpack(">d", content[:8]) == (1 / PERIOD,)
                    self._output_names = content[8:].decode("ascii").split(",")
                    types = [OUTPUTS.get(n, ("NOT_FOUND", ""))[0] for n in self._output_names]
                    self._send("O", bytes([1]) + ",".join(types).encode("ascii"))
                case "I":
                    self._input_names = content.decode("ascii").split(",")
                    types = [
                        "IN_USE" if n in self.taken else INPUTS.get(n, ("NOT_FOUND", ""))[0]
                        for n in self._input_names
                    ]
                    self._send("I", bytes([2]) + ",".join(types).encode("ascii"))
                case "S":
                    self._send("S", b"\x01")
                    self._send_data()
                case "U":
                    self._cycle(content)
                case _:
                    message = f"a package of unknown type {kind!r}"
                    raise AssertionError(message)

    def _cycle(self, content: bytes) -> None:
        assert content[0] == 2
        layout = ">" + "".join(INPUTS[name][1] for name in self._input_names)
        values: dict[str, Any] = dict(
            zip(self._input_names, struct.unpack(layout, content[1:]), strict=True)
        )
        target = [values[f"input_double_register_{i}"] for i in range(24, 30)]
        if values["input_int_register_24"] == 0:
            self.running, self.runtime_state = 0, 1
        for _ in range(self.burst):
            if self.running:
                self.targets.append(target)
                self.qd = [(new - old) / PERIOD for new, old in zip(target, self.q, strict=True)]
                self.q = target
            else:
                self.qd = [0.0] * 6
            self.timestamp += PERIOD
            self._send_data()
        self.cycled.set()

    def _send_data(self) -> None:
        values: dict[str, Any] = {
            "timestamp": (self.timestamp,),
            "actual_q": self.q,
            "actual_qd": self.qd,
            "safety_mode": (self.safety_mode,),
            "runtime_state": (self.runtime_state,),
            "output_int_register_24": (self.running,),
        }
        content = bytes([1])
        for name in self._output_names:
            content += struct.pack(f">{OUTPUTS[name][1]}", *values[name])
        if self._client is not None:
            self._send("U", content)
