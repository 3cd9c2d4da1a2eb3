"""What presses, drags and the wheel do to the page in a real browser."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support.console_stand import RecordingCell
from support.page_desk import LIMIT_S, VIEW_FROM, page_of
from support.page_stand import BusyCellView


async def click(browser, x, y):
    """A press of the mouse, and its release."""
    given = {"x": x, "y": y, "button": "left", "clickCount": 1}
    await browser.call("Input.dispatchMouseEvent", type="mousePressed", **given)
    await browser.call("Input.dispatchMouseEvent", type="mouseReleased", **given)


def test_a_click_on_an_object_tells_what_is_known_of_it(desk, tmp_path):
    async def ask():
        async with page_of(desk, BusyCellView(busy=False), tmp_path) as browser:
            await click(browser, *await browser.run("yarmConsole.screen('ankurbot_1')"))
            told = await browser.until("document.querySelector('#picked').innerText", LIMIT_S)
            name, kind, at, cells, *rest = told.split("\n")
            assert (name, kind, at) == ("ankurbot_1", "Mobile, dynamic", "at 1.00, 0.00, 0.00 m, turned 0\u00b0")
            assert cells == f"cells: {await browser.run('yarmConsole.cells().ankurbot_1')}"
            assert any(line.startswith("in sight of: ") for line in rest)
            assert rest[-1] == "task: ankurbot_1 \u2192 debris_0, moving"
            box = await browser.run(
                "(({left, top}) => [left, top])(document.querySelector('#canvas').getBoundingClientRect())"
            )
            await click(browser, box[0] + 5, box[1] + 5)
            await browser.until("document.querySelector('#picked').hidden", LIMIT_S)
            await browser.run("yarmConsole.pick('debris_0')")
            told = await browser.run("document.querySelector('#picked').innerText")
            assert "seen by: camera 1, camera 3" in told.split("\n"), told

    desk.run(ask())


async def drag(browser, start, end):
    """The mouse pressed at a place, moved to another and let go there."""
    await browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=start[0], y=start[1])
    held = {"button": "left", "buttons": 1}
    await browser.call("Input.dispatchMouseEvent", type="mousePressed", x=start[0], y=start[1], clickCount=1, **held)
    for share in (0.25, 0.5, 0.75, 1.0):
        x, y = (a + share * (b - a) for a, b in zip(start, end))
        await browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, **held)
    await browser.call("Input.dispatchMouseEvent", type="mouseReleased", x=end[0], y=end[1], clickCount=1, **held)


def test_a_drag_goes_round_the_cell_and_the_wheel_comes_nearer(desk, tmp_path):
    async def look():
        async with page_of(desk, BusyCellView(busy=False), tmp_path) as browser:
            await browser.run(VIEW_FROM % "corner")
            before = np.array(await browser.run("yarmConsole.eye()"))
            await drag(browser, (600, 300), (300, 300))
            moved = "Math.hypot(...yarmConsole.eye().map((v, i) => v - %s[i])) > 1.0"
            await browser.until(moved % json.dumps(before.tolist()), LIMIT_S)
            round_ = np.array(await browser.run("yarmConsole.eye()"))
            assert round_[2] == pytest.approx(before[2], abs=0.05), "a level drag leaves the height"
            await browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=600, y=300, deltaX=0, deltaY=-400)
            await browser.until(f"yarmConsole.eye()[2] < {round_[2] - 0.1}", LIMIT_S)
            assert np.linalg.norm(await browser.run("yarmConsole.eye()")) < np.linalg.norm(round_)

    desk.run(look())


def test_why_is_asked_and_its_answer_shown(desk, tmp_path):
    cell = RecordingCell()

    async def ask():
        async with page_of(desk, BusyCellView(busy=False), tmp_path, cell) as browser:
            await browser.run("[...document.querySelectorAll('#tasks button')][0].click()")
            await browser.until("!document.querySelector('#why').hidden", LIMIT_S)
            told = await browser.until("document.querySelector('#why').innerText.includes('done')", LIMIT_S)
            goal = await browser.run("document.querySelector('#tasks td').innerText")
            assert told and goal.startswith("debris_0")

    desk.run(ask())
    assert cell.calls == [("why", "debris_0")]
