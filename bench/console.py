#!/usr/bin/env python3
"""What the console costs: its server with one page at ten pictures a second, and the memory of a page left open.

    python3 bench/console.py cost --address http://127.0.0.1:8470 [--seconds 60]
    python3 bench/console.py page --film results/2m1ma_bin/3/run.film [--csv bench/data/console_page.csv]

``cost`` is a page without a browser beside a running console on this machine: it takes every picture and says at once
that it is drawn, so that the server has to make all of them; a browser on a machine without a graphics card asks for
fewer. ``page`` serves a film as if it were live, over and over and as fast as the page shows it, to a headless Chromium
with a small window, whose WebGL takes all that the page gives it but paints nothing: painting without a graphics card
would take most of the time. An hour at ten pictures a second is 36 000 of them (``--pictures``). At first and twelve
times on the way it writes what the page's scripts hold after a collection, how many elements and listeners there are,
and what the page's process and all of the browser's processes hold.
"""

from __future__ import annotations

import argparse
import asyncio
import csv
import sys
import tempfile
import time
from pathlib import Path
from typing import Dict, List, Tuple

import aiohttp
import psutil

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))
from support.browser import Browser, chromium
from support.page_stand import SMALL_PX, UNPAINTED, FilmView, page_served
from yarm.commander.requests import Request
from yarm.console.cell import Answer
from yarm.console.film import Film
from yarm.console.params import ConsoleParams
from yarm.console.server import Live
from yarm.console.wire import decode

MB = 2.0**-20
ROWS = 12
Row = Dict[str, float]


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
    return float(sum(child.memory_info().rss for child in children if child.is_running())) * MB


def page_process_mb() -> float:
    """Memory that is the page's process' own (the largest of the browser's renderers), MB."""
    children = psutil.Process().children(recursive=True)
    renderers = [child for child in children if "--type=renderer" in child.cmdline()]
    return float(max(child.memory_full_info().uss for child in renderers)) * MB


async def row_of(browser: Browser) -> Row:
    """Pictures shown so far, and what is held after a collection: by the page's scripts, by all of the browser, MB."""
    await browser.call("HeapProfiler.collectGarbage")
    heap = await browser.call("Runtime.getHeapUsage")
    counted = await browser.call("Memory.getDOMCounters")
    return {
        "pictures": float(await browser.run("yarmConsole.pictures()")),
        "page_mb": float(heap["usedSize"]) * MB,
        "elements": float(counted["nodes"]),
        "listeners": float(counted["jsEventListeners"]),
        "page_process_mb": page_process_mb(),
        "browser_mb": held_mb(),
    }


async def watch(options: argparse.Namespace) -> List[Row]:
    """Rows over the pictures that the page has shown."""
    shown, rows = Live(NobodyCell(), FilmView(Film.read(options.film))), []
    async with page_served(shown, tempfile.gettempdir(), rate_hz=30.0, film_hz=10.0) as address, chromium() as browser:
        await browser.call("Page.addScriptToEvaluateOnNewDocument", source=UNPAINTED)
        await browser.size(*SMALL_PX)
        await browser.open(address)
        await browser.until("window.yarmConsole && yarmConsole.pictures() > 1", 120.0)
        for wanted in range(0, options.pictures + 1, max(1, options.pictures // ROWS)):
            await browser.until(f"yarmConsole.pictures() >= {wanted}", options.limit_s)
            rows.append(await row_of(browser))
            print(" ".join(f"{name} {value:.1f}" for name, value in rows[-1].items()), flush=True)
    return rows


def page(options: argparse.Namespace) -> None:
    """Watch a page, write the rows, and say by how much it has grown."""
    rows = asyncio.run(watch(options))
    if options.csv is not None:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
            writer.writeheader()
            writer.writerows({name: round(value, 2) for name, value in row.items()} for row in rows)
    for name in ("page_mb", "page_process_mb", "browser_mb"):
        values = [row[name] for row in rows]
        print(f"{name}: {values[0]:.1f} at first, {values[-1]:.1f} at the end, {max(values):.1f} at most")


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
    browser.add_argument("--pictures", type=int, default=36_000)
    browser.add_argument("--limit-s", type=float, default=1800.0, help="wall time between two rows at most")
    browser.add_argument("--csv", type=Path)
    browser.set_defaults(run=page)
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
