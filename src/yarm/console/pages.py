"""The open pages: each gets the newest picture when it has shown the last ones, and never one that is old."""

from __future__ import annotations

import asyncio
import contextlib
import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional

from aiohttp import WSMsgType, web

from yarm.console.cell import View
from yarm.console.film import Film
from yarm.console.guard import refusal
from yarm.console.limits import Bucket, Rate

MOST_PAGES = 12
MESSAGE_BYTES = 256
"""Greatest message of a page."""
MESSAGES = Rate(60.0, 120.0)
"""Messages of one page: it acknowledges each picture."""
AHEAD = 2
"""Pictures a page may have been sent and not acknowledged."""
HEARTBEAT_S = 30.0
PAUSE = 0.2
"""Part of a period that lies between two pictures at least."""
POLICY = 1008


class Page:
    """One open page."""

    def __init__(self, socket: web.WebSocketResponse) -> None:
        """Nothing sent yet."""
        self.socket = socket
        self.sent = self.shown = 0
        self.number = 0
        self.versions: Dict[str, int] = {}
        self.wake = asyncio.Event()


@dataclass(frozen=True)
class Filming:
    """A film that is taken of a view, and how often, s of wall time."""

    film: Film
    period_s: float


def _next_due(due_s: float, period_s: float, now_s: float) -> float:
    """When the next one is due after the one that was due at ``due_s``; PAUSE of a period from now at the soonest."""
    return max(due_s + period_s, now_s + PAUSE * period_s)


class Pages:
    """Sends to every page; nothing is made while none is open, but for a film."""

    def __init__(
        self, view: View, rate_hz: float, warn: Callable[[str], None], filming: Optional[Filming] = None
    ) -> None:
        """Set up; ``run`` does the work.

        Args:
            view: what is shown.
            rate_hz: pictures a second.
            warn: takes a line about each page that is thrown out.
            filming: the film that is taken meanwhile; None for none.
        """
        self._view, self._period_s, self._warn = view, 1.0 / rate_hz, warn
        self._filming, self._filmed_s, self._film_at = filming, -1.0, 0.0
        self._open: List[Page] = []
        self._picture = b""
        self._number = 0

    async def run(self) -> None:
        """Make pictures until cancelled: each when it is due, whatever the one before took.

        One that is late comes a part of a period after the one before, so that there is time for everything else.
        """
        due_s = time.monotonic()
        while True:
            due_s = _next_due(due_s, self._period_s, time.monotonic())
            await asyncio.sleep(due_s - time.monotonic())
            filming = self._film_is_due(time.monotonic())
            if not self._open and not filming:
                continue
            try:
                now_s = self._view.now_s()
                self._picture, self._number = self._view.state(), self._number + 1
                if filming is not None and now_s != self._filmed_s:
                    self._filmed_s = now_s
                    filming.film.add(now_s, self._view.parts(), self._picture)
            except ValueError as error:
                self._warn(f"no picture: {error}")
            for page in self._open:
                page.wake.set()

    def _film_is_due(self, wall_s: float) -> Optional[Filming]:
        if self._filming is None or wall_s < self._film_at:
            return None
        self._film_at = _next_due(self._film_at, self._filming.period_s, wall_s)
        return self._filming

    async def live(self, request: web.Request) -> web.StreamResponse:
        """Handler of the socket: pictures out, and back how many of them the page has shown."""
        if len(self._open) >= MOST_PAGES:
            return refusal(503, f"{MOST_PAGES} pages are open already; close one")
        socket = web.WebSocketResponse(max_msg_size=MESSAGE_BYTES, heartbeat=HEARTBEAT_S, compress=False)
        page = Page(socket)
        self._open.append(page)
        sender = None
        try:
            await socket.prepare(request)
            sender = asyncio.ensure_future(self._send(page))
            await self._listen(page, request.remote or "unknown")
        finally:
            self._open.remove(page)
            if sender is not None:
                sender.cancel()
        return socket

    async def close(self) -> None:
        """Say good-bye to every page."""
        for page in list(self._open):
            await page.socket.close(code=1001, message=b"the console ends")

    async def _listen(self, page: Page, peer: str) -> None:
        """A page says only how many pictures it has shown; who says anything else, or too much, is thrown out."""
        bucket = Bucket(MESSAGES, time.monotonic)
        async for message in page.socket:
            words = message.data if message.type is WSMsgType.TEXT else ""
            fault = "" if bucket.take() else f"more than {MESSAGES.per_s:g} messages a second"
            if not (isinstance(words, str) and words.isdecimal() and len(words) < 12):
                fault = fault or "a message that is no number of pictures"
            if fault:
                self._warn(f"page of {peer} closed: {fault}")
                await page.socket.close(code=POLICY, message=fault.encode())
                return
            page.shown = max(page.shown, min(int(words), page.sent))
            page.wake.set()

    async def _send(self, page: Page) -> None:
        with contextlib.suppress(ConnectionError):
            while True:
                await page.wake.wait()
                page.wake.clear()
                if page.number == self._number or page.sent - page.shown >= AHEAD:
                    continue
                for name, part in self._view.parts().items():
                    if page.versions.get(name) != part.version:
                        page.versions[name] = part.version
                        await page.socket.send_bytes(part.message)
                page.number, page.sent = self._number, page.sent + 1
                await page.socket.send_bytes(self._picture)
