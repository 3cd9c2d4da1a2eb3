"""What a person sees of an experiment: its own lines as they come; everything else goes to a log file."""

from __future__ import annotations

import re
import sys
import threading
from pathlib import Path
from typing import IO, List

MARK = "[experiment] "
"""Begins every line of the node ``run_experiment`` that is meant for the person at the terminal."""
LAST_LINES = 15
RELEVANT = re.compile(r"\b(ERROR|FATAL|WARN|Traceback|\w*Error|died|RLException)\b")
ENDINGS = (
    "REQUIRED process [run_experiment",
    "run_experiment --node",
    "REQUIRED process [run_exploration",
    "run_experiment --exploration",
    "REQUIRED process [inspector",
    "run_experiment --inspection",
)
"""How roslaunch says that the experiment is over, well or not."""
COLOURS = re.compile(r"\x1b\[[0-9;]*m|\x1b\][^\x07]*\x07")
END_LIMIT_S = 5.0


def say(text: str) -> None:
    """Lines for the person at the terminal, at once."""
    sys.stdout.write("".join(f"{MARK}{line}".rstrip() + "\n" for line in text.split("\n")))
    sys.stdout.flush()


class Console:
    """Takes in a child's output: all of it into a log, the marked lines to the terminal as well."""

    def __init__(self, output: IO[bytes], log: Path) -> None:
        """Read until the output ends.

        Args:
            output: standard output and error of the child, in one.
            log: file to write; an older one is replaced.
        """
        self._output = output
        self._log = log.open("wb")
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def finish(self) -> None:
        """Wait for what is still on its way; a process that has outlived the child may hold the output open."""
        self._reader.join(END_LIMIT_S)

    def _read(self) -> None:
        with self._log:
            for line in iter(self._output.readline, b""):
                self._log.write(line)
                self._log.flush()
                text = COLOURS.sub("", line.decode(errors="replace")).rstrip()
                mark = MARK.rstrip()
                if text.startswith(mark):
                    sys.stdout.write(text[len(MARK) :] + "\n")
                    sys.stdout.flush()


def last_words(log: Path) -> List[str]:
    """The last lines of a log that say what went wrong; its very last ones when none does."""
    lines = [COLOURS.sub("", line).rstrip() for line in log.read_text(errors="replace").splitlines()]
    lines = [
        line
        for line in lines
        if line and not line.startswith(MARK.rstrip()) and not any(ending in line for ending in ENDINGS)
    ]
    relevant = [line for line in lines if RELEVANT.search(line)]
    return (relevant or lines)[-LAST_LINES:]
