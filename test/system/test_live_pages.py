"""The page in a browser beside each system as a person starts it: what it shows, its stop, and how all goes on then."""

from __future__ import annotations

import asyncio
import json
import re
import time
from contextlib import asynccontextmanager
from pathlib import Path
from typing import AsyncIterator, List

import pytest

from support.browser import Browser, chromium
from support.launched import ROOT, Launched
from yarm.ros.experiment.ports import free_port

LIMIT_S = 300.0
STILL_M, MOVED_M, RESTS_FOR_S = 0.02, 0.1, 1.0
STATE = """({
  at: Object.fromEntries(yarmConsole.bodies().filter((body) => body.at).map((body) => [body.name, body.at])),
  time_s: yarmConsole.newest().time_s,
})"""
FACTS = "document.querySelector('#room').innerText"


def launched(words: List[str], folder: Path) -> Launched:
    """``roslaunch yarm`` with a page at a free port, on a master of its own."""
    port = free_port()
    environment = {"ROS_MASTER_URI": f"http://localhost:{port}", "PWD": str(folder)}
    call = ["roslaunch", "-p", str(port), "yarm", *words, "console:=true", "console_port:=0"]
    return Launched(call, f"live_page_{words[0].partition('.')[0]}", environment, folder)


async def address_of(child: Launched) -> str:
    """What it prints, token and all."""
    deadline = time.monotonic() + LIMIT_S
    while True:
        found = re.search(r"console: (http://\S+#token=\S+)", child.output())
        if found:
            return found.group(1)
        assert child.running() and time.monotonic() < deadline, child.output()[-4000:]
        await asyncio.sleep(0.2)


@asynccontextmanager
async def page_of(child: Launched) -> AsyncIterator[Browser]:
    """Its page in a browser, when it has drawn something; it asks for nothing elsewhere and logs no errors."""
    address = await address_of(child)
    async with chromium() as page:
        await page.open(address)
        await page.until("window.yarmConsole && yarmConsole.pictures() > 1", LIMIT_S)
        yield page
        base = address.partition("#")[0]
        assert [asked for asked in page.asked if not asked.startswith(base)] == []
        assert page.errors == []


async def moves(page: Browser, name: str) -> None:
    """Until a body has gone a way from where it is now, or from where it is first known to be."""
    await page.until(f"yarmConsole.bodies().some((body) => body.name === '{name}' && body.at)", LIMIT_S)
    at = json.dumps((await page.run(STATE))["at"][name])
    body = f"yarmConsole.bodies().find((body) => body.name === '{name}')"
    gone = f"{body}.at.some((v, i) => Math.abs(v - {at}[i]) > {MOVED_M})"
    await page.until(gone, LIMIT_S)


async def stops_and_goes_on(page: Browser, name: str) -> None:
    """One press and everything stands; two presses more, and it goes on with what it did."""
    await page.run("document.querySelector('#stop').click()")
    await page.until("document.querySelector('#stop-state').textContent.startsWith('STOPPED')", LIMIT_S)
    since_s = await page.run("yarmConsole.newest().time_s + 0.5")
    first = await page.until(f"yarmConsole.newest().time_s >= {since_s} && {STATE}", LIMIT_S)
    then = await page.until(f"yarmConsole.newest().time_s >= {first['time_s'] + RESTS_FOR_S} && {STATE}", LIMIT_S)
    for a, b in zip(first["at"][name], then["at"][name]):
        assert abs(a - b) < STILL_M, f"{name} has moved: {first}, {then}"
    await page.run("document.querySelector('#release').click()")
    await page.until("!document.querySelector('#confirm').hidden", LIMIT_S)
    await page.run("document.querySelector('#confirm').click()")
    await page.until("!document.body.classList.contains('stopped')", LIMIT_S)
    await moves(page, name)


async def explored(child: Launched) -> None:
    async with page_of(child) as page:
        await page.until(f"{FACTS}.includes('Exploration') && {FACTS}.includes('exploring')", LIMIT_S)
        first = await page.until("yarmConsole.room().seen.length === 4 && yarmConsole.room().seen", LIMIT_S)
        await moves(page, "turtlebot")
        await stops_and_goes_on(page, "turtlebot")
        grown = "(([a, b, c, d]) => (c - a) * (d - b))(yarmConsole.room().seen)"
        await page.until(f"{grown} > {1.1 * (first[2] - first[0]) * (first[3] - first[1])}", LIMIT_S)
        low_x, low_y, high_x, high_y = await page.run("yarmConsole.room().seen")
        x, y, _ = (await page.run(STATE))["at"]["turtlebot"]
        assert low_x < x < high_x and low_y < y < high_y, "the robot is on what it has seen"


async def inspected(child: Launched) -> None:
    async with page_of(child) as page:
        await page.until(f"{FACTS}.includes('Inspection')", LIMIT_S)
        await page.until("yarmConsole.room().marks > 0 && yarmConsole.room().texts > 0", LIMIT_S)
        await moves(page, "turtlebot")
        await stops_and_goes_on(page, "turtlebot")
        verdict = "document.querySelector('#verdicts tbody').innerText.match(/^\\d+/)"
        box = (await page.until(f"{verdict} && {verdict}", LIMIT_S))[0]
        assert re.search(rf"verdict: box {box}\b", child.output()), child.output()[-4000:]


async def cleared(child: Launched) -> None:
    async with page_of(child) as page:
        await page.until(f"{FACTS}.includes('clears its floor')", LIMIT_S)
        (moving,) = [name for name in (await page.run(STATE))["at"] if name == "youbot"]
        await moves(page, moving)
        await stops_and_goes_on(page, moving)
        await page.until(f"/[1-9] of [0-9]+ pieces/.test({FACTS})", LIMIT_S)


@pytest.mark.parametrize(
    ("words", "look"),
    [
        (["exploration.launch", "arena:=practice", "score:=false"], explored),
        (["inspection.launch", "layout:=practice"], inspected),
        (["youbot.launch", "clear:=true", "seed:=1"], cleared),
    ],
)
def test_a_page_shows_what_goes_on_and_its_stop_is_no_end(words: List[str], look, tmp_path: Path) -> None:
    with launched(words, tmp_path) as child:
        asyncio.run(look(child))


async def demonstrated(child: Launched) -> None:
    async with page_of(child) as page:
        await page.until("document.querySelector('#state').textContent.startsWith('BOUNDLESS')", LIMIT_S)
        assert "ankurbot_1" in (await page.run(STATE))["at"] and await page.run("yarmConsole.cellsDrawn()") > 100
        await page.until("document.querySelector('#tasks').textContent.includes('debris_1')", LIMIT_S)


def test_make_demo_shows_the_cell_at_the_one_address_that_it_prints() -> None:
    call = ["make", "-o", "build", "demo", "CONSOLE=1"]  # it is built: a second build would write what others run
    with Launched(call, "live_page_demo", {}, ROOT) as child:
        asyncio.run(demonstrated(child))
        assert child.ended(LIMIT_S) == 0, child.output()[-4000:]
        assert len(set(re.findall(r"http://\S+#token=\S+", child.output()))) == 1
