"""The access rules at the door of the console's server: each request passes here first."""

from __future__ import annotations

import time
from asyncio import sleep
from collections import Counter
from typing import Awaitable, Callable, Optional

from aiohttp import web

from yarm.console.access import TokenGate, host_fault, is_loopback, origin_fault
from yarm.console.limits import Bucket, Clock, PeerBuckets, Rate

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

BODY_BYTES = 4096
"""Greatest body of a request."""
REQUESTS = Rate(50.0, 200.0)
"""Requests of one peer, but for commands: those of who has the token are not held up by others at its address."""
COMMANDS = Rate(5.0, 10.0)
"""Commands with the right token, but for the stop."""
STOPS = Rate(10.0, 20.0)
QUESTIONS = Rate(1.0, 5.0)
"""Questions of one peer that the Commander has to think about."""
WAITING = 8
"""Tokens of one peer that may wait to be looked at."""
COMMAND, STOP = "/command/", "/command/stop"
BEARER = "Bearer "


def refusal(status: int, message: str) -> web.Response:
    """An answer that says no, and why."""
    return web.json_response({"success": False, "message": message}, status=status)


class Guard:
    """Decides on each request: host, origin, token, size and rate."""

    def __init__(self, host: str, token: str, warn: Callable[[str], None], clock: Clock = time.monotonic) -> None:
        """Set up.

        Args:
            host: address that the server listens on; on loopback looking is free.
            token: what commands need.
            warn: takes a line about each refusal that somebody may want to know of.
            clock: seconds that never go backwards.
        """
        self.open_to_look = is_loopback(host)
        self._host, self._warn = host, warn
        self._gate = TokenGate(token, clock, warn)
        self._requests = PeerBuckets(REQUESTS, clock)
        self._questions = PeerBuckets(QUESTIONS, clock)
        self._commands, self._stops = Bucket(COMMANDS, clock), Bucket(STOPS, clock)
        self._waiting: Counter[str] = Counter()

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Let a request through to its handler, or refuse it."""
        refused = self._refused_at_once(request)  # an empty mapping to Python, so "or" would pass it over
        if refused is None:
            refused = await self._refused_by_token(request)
        if refused is None:
            refused = self._too_often(request)
        return await handler(request) if refused is None else refused

    def _refused_at_once(self, request: web.Request) -> Optional[web.Response]:
        """What needs no token to be refused."""
        if not request.path.startswith(COMMAND) and not self._requests.take(peer_of(request)):
            return refusal(429, f"too many requests: {REQUESTS.per_s:g} a second are answered")
        fault = host_fault(request.headers.get("Host", ""), self._host)
        if fault:
            return refusal(421, fault)
        fault = origin_fault(request.headers.get("Origin", ""), request.headers.get("Host", ""))
        if fault:
            self._warn(f"refused {request.path} for {peer_of(request)}: {fault}")
            return refusal(403, fault)
        if request.method == "POST" and request.content_type != "application/json":
            return refusal(415, f"a request's body must be application/json, it is {request.content_type}")
        return None

    async def _refused_by_token(self, request: web.Request) -> Optional[web.Response]:
        """A command needs the token in its own header, so that no page of somebody else's can have it sent along."""
        command = request.path.startswith(COMMAND)
        if not command and self.open_to_look:
            return None
        given = bearer(request) if command else bearer(request) or self._carried(request)
        peer = peer_of(request)
        if request.path == STOP and self._gate.right(peer, given):
            return None
        if self._waiting[peer] >= WAITING:
            return refusal(429, "too many wrong tokens; wait a little")
        self._waiting[peer] += 1
        try:
            await sleep(self._gate.wait_s(peer))
            if request.path != STOP and self._gate.right(peer, given):
                return None
        finally:
            self._waiting[peer] -= 1
            self._waiting += Counter()  # forget the zeros
        return refusal(401, "the token is wrong" if given else "this needs the token that the console printed")

    def _too_often(self, request: web.Request) -> Optional[web.Response]:
        """Commands and questions too often."""
        if request.path == STOP:
            allowed = self._stops.take()
        elif request.path.startswith(COMMAND):
            allowed = self._commands.take()
        elif request.path.startswith("/ask/"):
            allowed = self._questions.take(peer_of(request))
        else:
            return None
        return None if allowed else refusal(429, f"too many requests for {request.path}; wait a little")

    @staticmethod
    def _carried(request: web.Request) -> str:
        """The token as a browser brings it: in the address it was given, or in the cookie it got for that."""
        return request.query.get("token", "") or request.cookies.get(cookie_name(request), "")


def peer_of(request: web.Request) -> str:
    """Address of who asks."""
    return request.remote or "unknown"


def bearer(request: web.Request) -> str:
    """The token in a request's header; empty without one."""
    words = request.headers.get("Authorization", "")
    return words[len(BEARER) :] if words.startswith(BEARER) else ""


def cookie_name(request: web.Request) -> str:
    """Name of the cookie, with our port: browsers send a cookie to each port of a host."""
    _, _, port = request.host.rpartition(":")
    return f"yarm_console_{port}"
