"""Keeps a program running: ``supervise [--verdict] PROGRAM [ARGUMENT ...]`` (docs/safety.md, "Nodes that die").

It is the ``launch-prefix`` of the cell's nodes. roslaunch's own ``respawn`` starts again at once or after a fixed
pause, for ever and without a word; this one waits longer each time, gives up, and tells the new process in its
environment, from which it says so on ``/diagnostics``. A program that has given signs of life (``yarm.safety.pulse``)
and gives none any more is named, then killed, and started again too. With ``--verdict`` the program's exit code is its
verdict and not a death.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import subprocess
import sys
import time
from io import FileIO
from typing import List, Optional, Sequence, Tuple

from yarm.safety.kept import KEPT, made
from yarm.safety.pulse import PULSE
from yarm.safety.restarts import Restarts

RESTARTS, LAST_END = "YARM_RESTARTS", "YARM_LAST_END"
"""Variables of a new process: how often it was started again, and how it ended the last time."""
LIFE = "YARM_LIFE"
"""Variable of every process of one supervisor: what is its own in journals."""
POLL_S = 0.05
"""Wall time between two looks at the pause's end, s."""
LOOK_S = 0.5
"""Wall time between two looks at a program that runs, s; a sign of life or its end comes at once."""
NAMED_S, HANGS_S = 3.0, 20.0
"""Wall time without a sign of life after which a program is named, and killed, s."""
VERDICT = "--verdict"
PR_SET_PDEATHSIG = 1
GAVE_UP = 1
USAGE = 2


class Supervisor:
    """One program, its restarts, and the signals that are handed on to it."""

    def __init__(
        self, program: Sequence[str], named_s: float = NAMED_S, hangs_s: float = HANGS_S, verdict: bool = False
    ) -> None:
        """Nothing is started yet; times as above, ``verdict`` as of ``Restarts``."""
        self._program = list(program)
        self._named_s, self._hangs_s = named_s, hangs_s
        self._name = os.path.basename(next((w.partition(":=")[2] for w in program if w.startswith("__name:=")), ""))
        self._name = self._name or os.path.basename(program[0])
        self._restarts = Restarts(verdict)
        self._life = f"{os.getpid()}-{time.time_ns()}"
        self._kept = made()
        self._child: Optional[subprocess.Popen[bytes]] = None
        self._stopped_by = 0

    def run(self) -> int:
        """Until the program ends for good.

        Returns:
            its exit code, 128 and the signal's number when it was told to end by one; 1 when it was given up.
        """
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._on_signal)
        while True:
            began_s = time.monotonic()
            code, hung = self._live()
            if self._stopped_by:
                return code if code >= 0 else 128 - code
            verdict = self._restarts.died(code, began_s, time.monotonic(), hung)
            if not verdict.again:
                if code != 0 and not (code > 0 and self._restarts.verdict):
                    self._say(f"is not started again: {verdict.reason}")
                return code if code >= 0 else GAVE_UP
            self._say(f"{self._restarts.last}; started again in {verdict.delay_s:g} s")
            self._pause(verdict.delay_s)
            if self._stopped_by:
                return 128 + self._stopped_by

    def _live(self) -> Tuple[int, str]:
        """One process from its start to its end: its exit code, and how it hung when it did."""
        pulse, writer = os.pipe()
        self._child = child = self._start(writer)
        os.close(writer)
        with open(pulse, "rb", buffering=0) as signs:
            os.set_blocking(pulse, False)
            hung = self._watch(child, signs)
        return child.wait(), hung

    def _watch(self, child: subprocess.Popen[bytes], signs: FileIO) -> str:
        """Until it has ended, or was killed because it hangs.

        A look that comes late says that the machine is busy, and counts as one in time.
        """
        silent_s, beats, named, last_s = 0.0, False, False, time.monotonic()
        while child.poll() is None:
            ready = select.select([signs], [], [], LOOK_S)[0]
            now_s = time.monotonic()
            silent_s, last_s = silent_s + min(now_s - last_s, 2.0 * LOOK_S), now_s
            sign = signs.read(4096) if ready else None
            if sign:
                silent_s, beats, named = 0.0, True, False
            elif sign == b"":  # its end of the pipe is closed: it ends, or wants to be watched no more
                time.sleep(POLL_S)
                beats = False
            if beats and silent_s > self._hangs_s and not self._stopped_by:
                child.kill()
                return f"hung, without a sign of life for {self._hangs_s:g} s"
            if beats and not named and silent_s > self._named_s:
                named = True
                self._say(f"no sign of life for {self._named_s:g} s; is started again after {self._hangs_s:g} s")
        return ""

    def _start(self, pulse: int) -> subprocess.Popen[bytes]:
        """In a session of its own, so that each signal reaches it once, from here; it dies with this process."""
        environment = {**os.environ, LIFE: self._life, PULSE: str(pulse), KEPT: str(self._kept)}
        if self._restarts.count:
            environment.update({RESTARTS: str(self._restarts.count), LAST_END: self._restarts.last})
        return subprocess.Popen(
            self._program,
            env=environment,
            pass_fds=(pulse, self._kept),
            start_new_session=True,
            preexec_fn=die_with_parent,  # noqa: PLW1509 (there are no threads)
        )

    def _on_signal(self, number: int, _: object) -> None:
        self._stopped_by = number
        if self._child is not None and self._child.poll() is None:
            self._child.send_signal(number)

    def _pause(self, seconds: float) -> None:
        until_s = time.monotonic() + seconds
        while time.monotonic() < until_s and not self._stopped_by:
            time.sleep(POLL_S)

    def _say(self, what: str) -> None:
        sys.stderr.write(f"{self._name}: {what}\n")
        sys.stderr.flush()


def die_with_parent() -> None:
    """Have this process killed as soon as the thread that has started it is gone."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def main(arguments: List[str]) -> int:
    """The command; its exit code."""
    verdict = arguments[:1] == [VERDICT]
    program = arguments[verdict:]
    if not program:
        sys.stderr.write(f"usage: supervise [{VERDICT}] PROGRAM [ARGUMENT ...]\n")
        return USAGE
    try:
        return Supervisor(program, verdict=verdict).run()
    except OSError as error:
        sys.stderr.write(f"supervise: {program[0]} cannot be started: {error}\n")
        return USAGE
