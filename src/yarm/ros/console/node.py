"""Node ``console``: serves a page in the browser that shows a running cell and commands it (docs/console.md).

With ``--run`` it shows a recorded run instead, and is no node.

It listens and asks; nothing depends on it, so it may be ended at any time.
"""

from __future__ import annotations

import argparse
import asyncio
import logging
import sys
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Callable, Optional, Sequence

import rospy
from aiohttp import web

from yarm.console.access import TokenError, is_loopback, new_token, read_token
from yarm.console.film import FilmError
from yarm.console.params import ConsoleParams
from yarm.console.results import ResultError
from yarm.console.server import ConsoleServer, Live
from yarm.params import ParamError, build
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.params import load_params
from yarm.ros.common.start import init_command
from yarm.ros.console.links import RosCell
from yarm.ros.console.recorded import recorded
from yarm.ros.console.view import LiveView
from yarm.safety.kept import Kept
from yarm.safety.pulse import PERIOD_S, Pulse

FAILED = 1
EVERY_INTERFACE = ("0.0.0.0", "::")


def address(host: str, port: int, token: str) -> str:
    """What a person types into the browser; without a token when it is in a file.

    Args:
        host: that the console listens on.
        port: that it got.
        token: empty when the person has it already.
    """
    shown = "THIS-MACHINE" if host in EVERY_INTERFACE else host
    shown = f"[{shown}]" if ":" in shown else shown
    if not token:
        return f"http://{shown}:{port}/"
    return f"http://{shown}:{port}/#token={token}" if is_loopback(host) else f"http://{shown}:{port}/?token={token}"


async def serve(
    application: web.Application,
    params: ConsoleParams,
    made_token: str,
    told: Callable[[int], None] = lambda port: None,
) -> None:
    """Until the node is shut down.

    Args:
        application: what is served.
        params: host and port.
        made_token: what the address that is printed has; empty when the person has it already.
        told: takes the port that was got.

    Raises:
        OSError: the address cannot be listened on.
    """
    loop, ended, pulse = asyncio.get_running_loop(), asyncio.Event(), Pulse()
    runner = web.AppRunner(application, access_log=None)
    await runner.setup()
    try:
        await web.TCPSite(runner, params.host, params.port).start()
        port = runner.addresses[0][1]
        told(port)
        sys.stdout.write(f"console: {address(params.host, port, made_token)}\n")
        if params.token_file:
            sys.stdout.write(f"console: commands need the token in {params.token_file}\n")
        sys.stdout.flush()
        rospy.on_shutdown(lambda: loop.call_soon_threadsafe(ended.set))
        while not rospy.is_shutdown() and not ended.is_set():
            pulse.beat()
            with suppress(asyncio.TimeoutError):
                await asyncio.wait_for(ended.wait(), PERIOD_S)
    finally:
        await runner.cleanup()


def options(arguments: Sequence[str]) -> argparse.Namespace:
    """What is asked for on the command line, besides ROS's own ``_name:=value``."""
    parser = argparse.ArgumentParser(
        prog="console", description="A page in the browser that shows a running cell, or a recorded run."
    )
    parser.add_argument(
        "--run", type=Path, help="show a recorded run: its folder, its film or a bag; needs no ROS master"
    )
    parser.add_argument("--export", type=Path, metavar="FILE", help="with --run: write it as one HTML file, and end")
    parser.add_argument("--port", type=int, default=ConsoleParams.port, help="with --run: port; 0 takes a free one")
    found = parser.parse_args(arguments)
    if found.export is not None and found.run is None:
        parser.error("--export needs --run: the run that is to be exported")
    return found


def show_recorded(run: Path, export: Optional[Path], port: int) -> int:
    """Serve a recorded run until interrupted, or write it as one file; the exit code."""
    try:
        found = recorded(run)
        if export is not None:
            export.write_text(found.page(), encoding="utf-8")
            sys.stdout.write(f"console: {found.film.title} is in {export}, {export.stat().st_size / 1e6:.1f} MB\n")
            return 0
        params = build(ConsoleParams, {"port": port, "results": str(found.results)})
        server = ConsoleServer(params, new_token(), found.film, resource("web"), logging.getLogger(__name__).warning)
        asyncio.run(serve(server.application(), params, ""))  # there is nothing to command
    except (FilmError, ResultError, ParamError, OSError) as error:
        sys.stderr.write(f"console: {error}\n")
        return FAILED
    except KeyboardInterrupt:
        pass
    return 0


def main() -> int:
    """Run the node, or show what is recorded; the exit code."""
    asked = options(rospy.myargv(sys.argv)[1:])
    if asked.run is not None:
        return show_recorded(asked.run, asked.export, asked.port)
    return serve_live()


def serve_live() -> int:
    """Run the node; its exit code. One that is started again has the port and the token of the one before."""
    init_command(names.CONSOLE_NODE)
    kept = Kept()
    before = kept.words()
    try:
        params = load_params(ConsoleParams)
        params = replace(params, port=int(before.get("port", params.port)))
        made = "" if params.token_file else before.get("token") or new_token()
        token = made or read_token(Path(params.token_file))
        server = ConsoleServer(params, token, Live(RosCell(), LiveView(params)), resource("web"), rospy.logwarn)
        asyncio.run(
            serve(server.application(), params, made, lambda port: kept.keep({"port": str(port), "token": made}))
        )
    except (ParamError, TokenError) as error:
        sys.stderr.write(f"console: {error}\n")
        return FAILED
    except OSError as error:
        sys.stderr.write(
            f"console: cannot listen on {params.host}, port {params.port}: {error}; set ~port to another\n"
        )
        return FAILED
    return 0
