"""The operator's page beside an experiment: its port, and a token that is shown to the person and logged nowhere."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import tempfile
from typing import Iterator, List

from yarm.console.access import new_token
from yarm.console.params import ConsoleParams

HOST = "127.0.0.1"


def page_port(wanted: int = ConsoleParams.port) -> int:
    """The usual port of the page; a free one when somebody listens there."""
    for port in (wanted, 0):
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((HOST, port))
            return int(probe.getsockname()[1])
    raise OSError(f"no free port on {HOST}")


@contextlib.contextmanager
def page(wanted: bool) -> Iterator[List[str]]:
    """Launch arguments that bring up the page; its address is printed, its token file goes afterwards.

    Args:
        wanted: whether there is to be a page; without one there are no arguments.
    """
    if not wanted:
        yield []
        return
    token, port = new_token(), page_port()
    handle, path = tempfile.mkstemp(prefix="yarm-console-")
    try:
        with os.fdopen(handle, "w") as file:
            file.write(f"{token}\n")
        sys.stdout.write(f"console: http://{HOST}:{port}/#token={token}\n")
        sys.stdout.flush()
        yield ["console:=true", f"console_port:={port}", f"console_token:={path}"]
    finally:
        os.unlink(path)
