"""A real Chromium without a screen, steered over its debugging protocol: pages, scripts, pictures."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import itertools
import json
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, AsyncIterator, Dict, List

import aiohttp

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--mute-audio",
    "--remote-debugging-port=0",
    "--window-size=1280,800",
)
START_S = 60.0
CALL_S = 60.0


class PageError(AssertionError):
    """The page threw an error, or did not come to what it was to be."""


class Browser:
    """One page. Errors that it logs are kept in ``errors``, every address it asked for in ``asked``."""

    def __init__(self, session: aiohttp.ClientSession, port: int, socket: aiohttp.ClientWebSocketResponse) -> None:
        """Over an open connection to a page of a browser that listens on a port."""
        self._session, self._port, self._socket = session, port, socket
        self._numbers = itertools.count(1)
        self._answers: Dict[int, asyncio.Future] = {}
        self.errors: List[str] = []
        self.asked: List[str] = []
        self._reader = asyncio.ensure_future(self._read())

    @classmethod
    async def of(cls, session: aiohttp.ClientSession, port: int, page: Dict[str, Any]) -> Browser:
        """A page that the browser lists."""
        socket = await session.ws_connect(page["webSocketDebuggerUrl"], max_msg_size=2**26)
        browser = cls(session, port, socket)
        for domain in ("Page", "Runtime", "Network", "Log"):
            await browser.call(f"{domain}.enable")
        return browser

    async def another(self) -> Browser:
        """One more page of the same browser."""
        async with self._session.put(f"http://127.0.0.1:{self._port}/json/new?about:blank") as response:
            return await self.of(self._session, self._port, await response.json())

    async def call(self, method: str, **params: Any) -> Dict[str, Any]:
        """One command of the protocol, and its result."""
        number = next(self._numbers)
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": params})
        found = await asyncio.wait_for(answer, CALL_S)
        if "error" in found:
            raise PageError(f"{method}: {found['error']}")
        return found["result"]

    async def run(self, script: str) -> Any:
        """Value of an expression in the page; promises are waited for."""
        found = await self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise PageError(f"{script}: {found['exceptionDetails']}")
        return found["result"].get("value")

    async def until(self, script: str, limit_s: float = 30.0) -> Any:
        """The value of an expression as soon as it is true; wall time."""
        until_s = time.monotonic() + limit_s
        while True:
            value = await self.run(script)
            if value:
                return value
            if time.monotonic() > until_s:
                text = await self.run("document.body ? document.body.innerText : ''")
                raise PageError(f"never so within {limit_s:g} s: {script}; errors {self.errors}; the page: {text}")
            await asyncio.sleep(0.1)

    async def open(self, address: str) -> None:
        """Another page."""
        await self.call("Page.navigate", url=address)

    async def size(self, width: int, height: int, mobile: bool = False) -> None:
        """Another window."""
        await self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile
        )

    async def picture(self, path: Path) -> None:
        """What the window shows, as a file."""
        found = await self.call("Page.captureScreenshot", format="png")
        path.write_bytes(base64.b64decode(found["data"]))

    async def close(self) -> None:
        """Listen no more."""
        self._reader.cancel()
        await self._socket.close()

    async def _read(self) -> None:
        async for message in self._socket:
            told = json.loads(message.data)
            if "id" in told:
                self._answers.pop(told["id"]).set_result(told)
            elif told["method"] == "Network.requestWillBeSent":
                self.asked.append(told["params"]["request"]["url"])
            elif told["method"] == "Runtime.exceptionThrown":
                details = told["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description", details["text"]))
            elif told["method"] == "Log.entryAdded" and told["params"]["entry"]["level"] == "error":
                self.errors.append(str(told["params"]["entry"]))


@contextlib.asynccontextmanager
async def chromium() -> AsyncIterator[Browser]:
    """A browser of its own, with an empty profile; it is gone afterwards."""
    program = shutil.which("chromium")
    assert program, "chromium is not installed: make setup"
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        process = subprocess.Popen(
            [program, *FLAGS, f"--user-data-dir={profile}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            async with aiohttp.ClientSession() as session:
                port = await _port(Path(profile) / "DevToolsActivePort", process)
                async with session.get(f"http://127.0.0.1:{port}/json/list") as response:
                    pages = [page for page in await response.json() if page["type"] == "page"]
                browser = await Browser.of(session, port, pages[0])
                yield browser
                await browser.close()
        finally:
            process.terminate()
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


async def _port(file: Path, process: subprocess.Popen) -> int:
    until_s = time.monotonic() + START_S
    while time.monotonic() < until_s:
        assert process.poll() is None, f"chromium ended with exit code {process.returncode}"
        with contextlib.suppress(OSError, ValueError, IndexError):
            return int(file.read_text().split("\n")[0])
        await asyncio.sleep(0.1)
    raise PageError(f"chromium has not said its port within {START_S:g} s")
