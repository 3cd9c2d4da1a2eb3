"""The page of what is no cell but looks like one, open in a real browser, one after the other."""

from __future__ import annotations

import asyncio
import contextlib

from support.browser import chromium
from support.console_stand import RecordingCell
from support.page_stand import TOKEN, UNPAINTED, live, page_served

LIMIT_S = 300.0
PHONE, DESK = (390, 844), (1280, 800)
READY = "window.yarmConsole && yarmConsole.pictures() > 3 && document.querySelectorAll('#buttons button').length > 0"
VIEW_FROM = """
[...document.querySelectorAll("#presets button")].find((each) => each.textContent === "%s").click()
"""


class Desk:
    """A browser that one coroutine after the other uses."""

    def __init__(self):
        """Start it."""
        self.loop, self._open = asyncio.new_event_loop(), contextlib.AsyncExitStack()
        self.browser = self.run(self._open.enter_async_context(chromium()))

    def run(self, work):
        """What a coroutine gives."""
        return self.loop.run_until_complete(work)

    def close(self):
        """End it."""
        self.run(self._open.aclose())
        self.loop.close()


@contextlib.asynccontextmanager
async def page_of(desk, view, folder, cell=None, size=DESK):
    """A page that shows a view and commands a cell, of a window's size; no error may be left on it."""
    async with page_served(live(cell or RecordingCell(), view), str(folder), rate_hz=30.0) as address:
        browser = await desk.browser.another()
        await browser.size(*size, mobile=size == PHONE)
        await browser.call("Page.addScriptToEvaluateOnNewDocument", source=UNPAINTED)
        await browser.open(f"{address}#token={TOKEN}")
        await browser.until(READY, LIMIT_S)
        yield browser
        assert browser.errors == []
        await leave(browser)


async def leave(browser):
    """The page lets go of its server, which waits for that."""
    await browser.open("about:blank")
    await browser.close()
