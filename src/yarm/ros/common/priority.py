"""Runs a program at a scheduling priority of its own.

roslaunch starts every node in a session of its own, and Linux shares the processors among sessions first (autogroup):
a node's nice value alone then counts against nobody. So the session's is set with it.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import List, Sequence

SESSION = Path("/proc/self/autogroup")


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


def main(arguments: Sequence[str]) -> None:
    """``NICE PROGRAM [ARGUMENT ...]``: becomes the program; what was refused is said, and it runs as it is."""
    nice, program = int(arguments[0]), list(arguments[1:])
    for line in set_priority(nice):
        sys.stderr.write(f"{os.path.basename(program[0])} runs without {line}\n")
    os.execvp(program[0], program)
