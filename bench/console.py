#!/usr/bin/env python3
"""What the console costs: its server with one page at ten pictures a second, and the memory of a page left open.

    python3 bench/console.py cost --address http://127.0.0.1:8470 [--seconds 60]
    python3 bench/console.py page --film results/2m1ma_bin/3/run.film [--minutes 60] [--csv bench/data/console_page.csv]

``cost`` is a page without a browser beside a running console on this machine: it takes every picture and says at once
that it is drawn, so that the server has to make all of them; a browser on a machine without a graphics card asks for
fewer. ``page`` serves a film as if it were live, over and over, to a headless Chromium, and writes each minute what
the page's own memory is after a collection, and what all processes of the browser hold.
"""

from __future__ import annotations

import argparse
import asyncio
import csv
import sys
import tempfile
import time
from pathlib import Path
from typing import Dict, List, Mapping, Tuple

import aiohttp
import psutil
from aiohttp import web

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))
from support.browser import Browser, chromium
from yarm.commander.requests import Request
from yarm.console.cell import Answer, Part
from yarm.console.film import Film, unpack
from yarm.console.params import ConsoleParams
from yarm.console.server import ConsoleServer, Live
from yarm.console.wire import decode
from yarm.resources import resource

MB = 2.0**-20
Row = Dict[str, float]


class FilmView:
    """Shows a film as if it were live, and again from its beginning when it is over."""

    def __init__(self, film: Film) -> None:
        """At its beginning."""
        index = film.index()
        entries = [entry for i in range(len(index["blocks"])) for entry in unpack(film.block(i) or b"")]
        self._entries = [(decode(message)[0]["kind"], message) for _, message in entries]
        self._at, self._made = 0, 0
        self._parts: Dict[str, Part] = {}
        self._state = b""

    def now_s(self) -> float:
        """A tenth of a second a picture, on and on."""
        return 0.1 * self._made

    def parts(self) -> Mapping[str, Part]:
        """The newest of each."""
        return dict(self._parts)

    def state(self) -> bytes:
        """The next."""
        self._made += 1
        while True:
            kind, message = self._entries[self._at]
            self._at = (self._at + 1) % len(self._entries)
            if kind == "state":
                self._state = message
                return self._state
            self._parts[kind] = Part(self._made, message)


class NobodyCell:
    """Does nothing that it is asked for."""

    def change_state(self, request: Request) -> Answer:
        """Refused."""
        return Answer(False, "a benchmark")

    def stop(self) -> Answer:
        """Refused."""
        return Answer(False, "a benchmark")

    def release(self) -> Answer:
        """Refused."""
        return Answer(False, "a benchmark")

    def why(self, subject: str) -> Answer:
        """Refused."""
        return Answer(False, "a benchmark")


def listener(port: int) -> psutil.Process:
    """The process that listens on a port of this machine."""
    for connection in psutil.net_connections("tcp"):
        if connection.status == psutil.CONN_LISTEN and connection.laddr.port == port and connection.pid:
            return psutil.Process(connection.pid)
    raise SystemExit(f"nobody listens on port {port}: start the console first")


async def take_pictures(address: str, seconds: float) -> Tuple[int, int]:
    """Pictures taken within so long, each acknowledged at once, and their bytes."""
    count = size = 0
    end_s = time.monotonic() + seconds
    async with aiohttp.ClientSession() as session, session.ws_connect(
        f"{address.rstrip('/')}/live", max_msg_size=0
    ) as socket:
        while time.monotonic() < end_s:
            message = await socket.receive(timeout=10.0)
            size += len(message.data)
            if decode(message.data)[0]["kind"] == "state":
                count += 1
                await socket.send_str(str(count))
    return count, size


def cost(options: argparse.Namespace) -> None:
    """Print what a running console costs with one page."""
    address = options.address.partition("#")[0]
    process = listener(int(address.rstrip("/").rpartition(":")[2]))
    before, begun_s = process.cpu_times(), time.monotonic()
    count, size = asyncio.run(take_pictures(address, options.seconds))
    after, took_s = process.cpu_times(), time.monotonic() - begun_s
    share = (after.user + after.system - before.user - before.system) / took_s
    memory = process.memory_info().rss * MB
    print(
        f"{count / took_s:.1f} pictures a second, {size / took_s / 1e3:.0f} kB/s: "
        f"{100 * share:.1f} % of a core, {memory:.0f} MB"
    )


def held_mb() -> float:
    """Resident memory of all processes that this one has started, MB; shared pages each time."""
    children = psutil.Process().children(recursive=True)
    return sum(child.memory_info().rss for child in children if child.is_running()) * MB


async def page_memory(browser: Browser) -> float:
    """What the page's scripts hold after a collection, MB."""
    await browser.call("HeapProfiler.collectGarbage")
    found = await browser.call("Runtime.getHeapUsage")
    return float(found["usedSize"]) * MB


async def watch(options: argparse.Namespace) -> List[Row]:
    """A row a minute."""
    params = ConsoleParams(port=0, results=tempfile.gettempdir(), film_s=600.0)
    server = ConsoleServer(
        params, "t" * 32, Live(NobodyCell(), FilmView(Film.read(options.film))), resource("web"), print
    )
    runner = web.AppRunner(server.application(), access_log=None)
    await runner.setup()
    await web.TCPSite(runner, params.host, 0).start()
    rows: List[Row] = []
    try:
        async with chromium() as browser:
            await browser.open(f"http://{params.host}:{runner.addresses[0][1]}/")
            await browser.until("window.yarmConsole && yarmConsole.pictures() > 1", 120.0)
            begun_s = time.monotonic()
            for minute in range(int(options.minutes) + 1):
                await asyncio.sleep(max(0.0, begun_s + 60.0 * minute - time.monotonic()))
                row = {
                    "minute": float(minute),
                    "page_mb": await page_memory(browser),
                    "browser_mb": held_mb(),
                    "pictures": float(await browser.run("yarmConsole.pictures()")),
                }
                rows.append(row)
                print(" ".join(f"{name} {value:.1f}" for name, value in row.items()), flush=True)
    finally:
        await runner.cleanup()
    return rows


def page(options: argparse.Namespace) -> None:
    """Watch a page, write the rows, and say by how much it has grown."""
    rows = asyncio.run(watch(options))
    if options.csv is not None:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows({name: round(value, 2) for name, value in row.items()} for row in rows)
    for name in ("page_mb", "browser_mb"):
        print(f"{name}: {rows[0][name]:.1f} at first, {rows[-1][name]:.1f} after {rows[-1]['minute']:.0f} minutes")


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    server = commands.add_parser("cost")
    server.add_argument("--address", default=f"http://127.0.0.1:{ConsoleParams.port}")
    server.add_argument("--seconds", type=float, default=60.0)
    server.set_defaults(run=cost)
    browser = commands.add_parser("page")
    browser.add_argument("--film", type=Path, required=True)
    browser.add_argument("--minutes", type=float, default=60.0)
    browser.add_argument("--csv", type=Path)
    browser.set_defaults(run=page)
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
