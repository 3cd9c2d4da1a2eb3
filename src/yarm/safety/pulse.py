"""Signs of life of a program to its supervisor (``yarm.safety.supervise``): a byte now and then through a pipe."""

from __future__ import annotations

import os
import threading
import time
from contextlib import AbstractContextManager, nullcontext
from typing import Optional

PULSE = "YARM_PULSE"
"""Variable with the number of the pipe's end that is written to."""
PERIOD_S = 0.5
"""Wall time between two signs, s."""


class Pulse:
    """Beats while the program is at work; without a supervisor nothing happens. Not thread-safe."""

    def __init__(self) -> None:
        """Find the pipe; programs that this one starts do not inherit it."""
        self._file: Optional[int] = None
        self._beat_s = 0.0
        number = os.environ.get(PULSE, "")
        if number.isdigit():
            try:
                os.set_inheritable(int(number), False)
                os.set_blocking(int(number), False)
                self._file = int(number)
            except OSError:
                return

    def beat(self) -> None:
        """Give a sign of life, at most every ``PERIOD_S``; called from where the work is done."""
        now_s = time.monotonic()
        if self._file is None or now_s - self._beat_s < PERIOD_S:
            return
        self._beat_s = now_s
        try:
            os.write(self._file, b".")
        except BlockingIOError:
            return
        except OSError:
            self._file = None


def beat_in_background(lock: Optional[AbstractContextManager[object]] = None) -> None:
    """Beat from a thread of its own for as long as the process lives.

    Args:
        lock: that all work is done under; who holds it for ever shows no life any more. None: only a process that is
            stopped as a whole shows none.
    """

    def run() -> None:
        pulse = Pulse()
        while True:
            with lock or nullcontext():
                pulse.beat()
            time.sleep(PERIOD_S)

    threading.Thread(target=run, daemon=True).start()
