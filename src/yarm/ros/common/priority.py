"""Runs a program at a scheduling priority of its own.

roslaunch starts every node in a session of its own, and Linux shares the processors among sessions first (autogroup):
a node's nice value alone then counts against nobody. So the session's is set with it.
"""

from __future__ import annotations

import os
import signal
import sys
import traceback
from pathlib import Path
from typing import Callable, List, Sequence

from yarm.safety.supervise import die_with_parent

SESSION = Path("/proc/self/autogroup")
HANDED_ON = (signal.SIGINT, signal.SIGTERM)
INTERRUPTED = 130
"""Exit code of who was interrupted."""


def set_priority(nice: int, session: Path = SESSION) -> List[str]:
    """Set the nice value of this process and of its session.

    Args:
        nice: -20 (first) to 19; a negative one needs the right to it.
        session: file that holds the session's; a kernel that does not share by sessions has none.

    Returns:
        what could not be set, and why; empty when all is well.
    """
    refused = []
    try:
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    except OSError as error:
        refused.append(f"nice value {nice} of the process: {error.strerror}")
    if session.exists():
        try:
            session.write_text(f"{nice}\n")
        except OSError as error:
            refused.append(f"nice value {nice} of the session: {error.strerror}")
    return refused


def lower(pid: int, nice: int) -> None:
    """Set the nice value of a process and of its session, 0 to 19.

    Raises:
        OSError: there is no such process.
    """
    os.setpriority(os.PRIO_PROCESS, pid, nice)
    session = Path(f"/proc/{pid}/autogroup")
    if session.exists():
        session.write_text(f"{nice}\n")


def in_own_session(nice: int, work: Callable[[], int]) -> int:
    """Do some work in a copy of this process, in a session of its own at a nice value of its own.

    In the caller's session the value would hold for whoever else is in it, a node or a person's shell, and stay. The
    copy dies with this process, and is told of its signals. Make it before threads are started, and before ROS is.

    Args:
        nice: as of ``set_priority``; what is refused is said, and the work done all the same.
        work: gives the exit code.

    Returns:
        the exit code; 128 and the signal's number of a copy that was killed.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    copy = os.fork()
    if copy == 0:
        os._exit(_alone(nice, work))
    before = {number: signal.signal(number, lambda got, _: os.kill(copy, got)) for number in HANDED_ON}
    try:
        code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return code if code >= 0 else 128 - code


def _alone(nice: int, work: Callable[[], int]) -> int:
    """The copy's part; never raises, as what is behind it is not the copy's."""
    code = 1
    try:
        die_with_parent()
        os.setsid()
        for line in set_priority(nice):
            sys.stderr.write(f"{os.path.basename(sys.argv[0])} runs without {line}\n")
        code = work()
    except KeyboardInterrupt:
        code = INTERRUPTED
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 1
    except Exception:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return code


def main(arguments: Sequence[str]) -> None:
    """``NICE PROGRAM [ARGUMENT ...]``: becomes the program; what was refused is said, and it runs as it is."""
    nice, program = int(arguments[0]), list(arguments[1:])
    for line in set_priority(nice):
        sys.stderr.write(f"{os.path.basename(program[0])} runs without {line}\n")
    os.execvp(program[0], program)
