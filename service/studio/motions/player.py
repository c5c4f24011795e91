"""Player: a time that goes on by itself, at a speed."""

import threading
from collections.abc import Callable

# Of pictures [1/s], which a browser without a graphics card still draws.
_RATE = 24.0


class Player:
    """Plays from a time to the end, in a thread of its own.

    Attributes:
        duration: Where it ends [s].
    """

    def __init__(self, duration: float, on_time: Callable[[float], None]) -> None:
        """Stand at the start.

        Args:
            duration: Where it ends [s].
            on_time: Called with each time that is to be shown, from the thread.
        """
        self.duration, self._on_time = duration, on_time
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._stop.set()

    @property
    def is_playing(self) -> bool:
        """Whether it goes on."""
        return not self._stop.is_set()

    def play(self, time: float, on_end: Callable[[], None]) -> None:
        """Play from a time on, or from the start if that is the end.

        Args:
            time: Where it begins [s].
            on_end: Called when it has come to its end, or was stopped.
        """
        self._stop.clear()
        begin = 0.0 if time >= self.duration - 1.0 / _RATE else time
        self._thread = threading.Thread(target=self._run, args=(begin, on_end), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Play no more, once the picture that is shown is there."""
        self._stop.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self, time: float, on_end: Callable[[], None]) -> None:
        while not self._stop.wait(1.0 / _RATE) and time < self.duration:
            time = min(self.duration, time + 1.0 / _RATE)
            self._on_time(time)
        self._stop.set()
        on_end()
