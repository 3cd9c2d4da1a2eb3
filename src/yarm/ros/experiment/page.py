"""The operator's page beside an experiment: its port, and a token that is shown to the person and logged nowhere."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Iterator, List, Sequence

from yarm.console.access import new_token
from yarm.console.params import ConsoleParams
from yarm.console.results import FILM
from yarm.ros.experiment.ports import HOST, free_port, is_free

POLL_S = 0.2
"""Wall time between two looks whether the page answers, s."""
PORT = "console_port:="


def page_port(wanted: int = ConsoleParams.port) -> int:
    """The usual port of the page; a free one when somebody listens there."""
    return wanted if is_free(wanted) else free_port()


@contextlib.contextmanager
def page(wanted: bool, results: Path) -> Iterator[List[str]]:
    """Launch arguments that bring up the page; its address is printed when it answers, its token file goes afterwards.

    Args:
        wanted: whether there is to be a page; without one there are no arguments.
        results: folder of results that it lists.
    """
    if not wanted:
        yield []
        return
    token, port = new_token(), page_port()
    handle, path = tempfile.mkstemp(prefix="yarm-console-")
    ended = threading.Event()
    says = threading.Thread(target=_say_when_it_answers, args=(port, token, ended), daemon=True)
    try:
        with os.fdopen(handle, "w") as file:
            file.write(f"{token}\n")
        sys.stdout.write("console: its address comes here as soon as the page answers\n")
        sys.stdout.flush()
        says.start()
        yield ["console:=true", f"{PORT}{port}", f"console_token:={path}", f"console_results:={results.resolve()}"]
    finally:
        ended.set()
        os.unlink(path)


def _say_when_it_answers(port: int, token: str, ended: threading.Event) -> None:
    """An address that is told before somebody listens there is one that a browser gives up on."""
    while not ended.wait(POLL_S):
        with contextlib.suppress(OSError), socket.create_connection((HOST, port), POLL_S):
            sys.stdout.write(f"console: http://{HOST}:{port}/#token={token}\n")
            sys.stdout.flush()
            return


def look_back(folder: Path, arguments: Sequence[str]) -> None:
    """Play the run on the same address, to which a page that is open goes over by itself, until a person ends it.

    Only where a person sits at the terminal, and there is something to play.

    Args:
        folder: of the run's results.
        arguments: as ``page`` gave them.
    """
    port = next((word[len(PORT) :] for word in arguments if word.startswith(PORT)), "")
    if not port or not sys.stdin.isatty() or not (folder / FILM).is_file():
        return
    sys.stdout.write("the page stays, with the run as it was; Ctrl-C ends it\n")
    sys.stdout.flush()
    with contextlib.suppress(KeyboardInterrupt):
        subprocess.run(["rosrun", "yarm", "console", "--run", str(folder), "--port", port], check=False)
