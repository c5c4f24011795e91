"""Newest: work in a thread of its own, of which only the newest request is carried out."""

import threading
from collections.abc import Callable


class Newest:
    """Carries out what was asked last; what was asked before it and has not begun is dropped.

    A slider asks faster than a server answers.
    """

    def __init__(self, on_fault: Callable[[Exception], None]) -> None:
        """Begin to wait for work.

        Args:
            on_fault: Is told what work raises.
        """
        self._on_fault = on_fault
        self._ready = threading.Condition()
        self._work: Callable[[], None] | None = None
        self._is_closed = False
        threading.Thread(target=self._run, daemon=True).start()

    def ask(self, work: Callable[[], None]) -> None:
        """Have work done in place of what waits."""
        with self._ready:
            self._work = work
            self._ready.notify()

    def close(self) -> None:
        """End the thread, once it has done what it does."""
        with self._ready:
            self._is_closed = True
            self._ready.notify()

    def _run(self) -> None:
        while True:
            with self._ready:
                self._ready.wait_for(lambda: self._work is not None or self._is_closed)
                work, self._work = self._work, None
            if self._is_closed or work is None:
                return
            try:
                work()
            except Exception as fault:  # noqa: BLE001  (told to the person at the browser)
                if not self._is_closed:  # what it was for is gone, and so are its places
                    self._on_fault(fault)
