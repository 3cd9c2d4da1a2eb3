"""A console without ROS around it, and clients that mean it ill."""

from __future__ import annotations

import asyncio
import contextlib
import threading

import numpy as np
from aiohttp.test_utils import TestClient, TestServer

from yarm.commander.requests import Request
from yarm.console.cell import Answer, Part
from yarm.console.params import ConsoleParams
from yarm.console.server import ConsoleServer, Live
from yarm.console.wire import encode

TOKEN = "right-token-right-token-right"
OWN = {"Authorization": f"Bearer {TOKEN}"}
LIMIT_S = 30.0


class RecordingCell:
    """Keeps what reaches it; ``gate`` holds its answers to everything but the stop."""

    def __init__(self):
        self.calls = []
        self.gate = threading.Event()
        self.gate.set()

    def change_state(self, request: Request) -> Answer:
        return self._take("state", request)

    def why(self, subject: str) -> Answer:
        return self._take("why", subject)

    def release(self) -> Answer:
        return self._take("release")

    def stop(self) -> Answer:
        self.calls.append(("stop",))
        return Answer(True, "everything stands")

    def _take(self, *call) -> Answer:
        self.gate.wait(LIMIT_S)
        self.calls.append(call)
        return Answer(True, "done")


class CountingView:
    """A picture that tells how many were made."""

    def __init__(self):
        self.scene_version = 1
        self.made = 0
        self.cells = 10

    def now_s(self) -> float:
        return 0.25 * self.made

    def parts(self):
        return {"scene": Part(self.scene_version, encode({"kind": "scene", "version": self.scene_version}, {}))}

    def state(self) -> bytes:
        self.made += 1
        return encode({"kind": "state", "made": self.made}, {"cells": np.zeros((self.cells, 3), np.uint8)})


class Stand:
    """One server on a free port of loopback, with a client; of a running cell unless a film is given."""

    def __init__(self, tmp_path, film=None, **params):
        (tmp_path / "vendor").mkdir(exist_ok=True)
        page = '<html><script type="importmap">{}</script></html>'
        for name, text in (
            ("index.html", page),
            ("main.js", "1;"),
            ("vendor/LICENSE", "words"),
            ("../secret.js", "no"),
        ):
            (tmp_path / name).write_text(text)
        self.cell, self.view, self.said = RecordingCell(), CountingView(), []
        params = {"rate_hz": 30.0, "film_s": 0.0, "results": str(tmp_path / "results"), **params}
        shown = film or Live(self.cell, self.view)
        self.server = ConsoleServer(ConsoleParams(**params), TOKEN, shown, tmp_path, self.said.append)

    @contextlib.asynccontextmanager
    async def open(self):
        async with TestClient(TestServer(self.server.application(), host="127.0.0.1")) as client:
            yield client


def run(test):
    """Run a coroutine to its end, within the limit."""

    async def limited():
        return await asyncio.wait_for(test, LIMIT_S)

    return asyncio.run(limited())


async def told(response):
    """Status and message of an answer."""
    return response.status, (await response.json())["message"]
