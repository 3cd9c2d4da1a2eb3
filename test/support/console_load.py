"""Loads a console as many greedy and hostile visitors do: ``python3 console_load.py ADDRESS``, until it is ended.

Pages that take every picture at once, whoever asks for the film and files again and again, and whoever guesses tokens.
Prints ``loaded`` when each has had its first answer.
"""

from __future__ import annotations

import asyncio
import sys
from typing import Callable, Coroutine

import aiohttp

PAGES, READERS, GUESSERS = 4, 4, 4
FILES = ("film", "main.js", "vendor/three/three.core.js", "about")
Visit = Callable[[aiohttp.ClientSession, asyncio.Event], Coroutine[None, None, None]]


def page(base: str) -> Visit:
    """A page that says at once that it has drawn what it was sent."""

    async def visit(session: aiohttp.ClientSession, served: asyncio.Event) -> None:
        async with session.ws_connect(f"{base}live", max_msg_size=0) as socket:
            count = 0
            async for _ in socket:
                served.set()
                count += 1
                await socket.send_str(str(count))
                await asyncio.sleep(0.02)

    return visit


def reader(base: str) -> Visit:
    """Somebody who asks for files."""

    async def visit(session: aiohttp.ClientSession, served: asyncio.Event) -> None:
        while True:
            for file in FILES:
                async with session.get(f"{base}{file}") as answer:
                    await answer.read()
                served.set()

    return visit


def guesser(base: str) -> Visit:
    """Somebody who guesses."""

    async def visit(session: aiohttp.ClientSession, served: asyncio.Event) -> None:
        guess = {"Authorization": "Bearer guess"}
        while True:
            async with session.post(f"{base}command/stop", json={}, headers=guess) as answer:
                assert answer.status != 200
            served.set()

    return visit


async def again(visit: Visit, served: asyncio.Event) -> None:
    """One visitor, who comes again when he is thrown out."""
    while True:
        try:
            async with aiohttp.ClientSession() as session:
                await visit(session, served)
        except aiohttp.ClientError:
            pass
        await asyncio.sleep(0.05)


async def load(base: str) -> None:
    """All of them, for ever."""
    visits = [page(base)] * PAGES + [reader(base)] * READERS + [guesser(base)] * GUESSERS
    served = [asyncio.Event() for _ in visits]
    going = [asyncio.ensure_future(again(visit, event)) for visit, event in zip(visits, served)]
    await asyncio.gather(*(event.wait() for event in served))
    sys.stdout.write("loaded\n")
    sys.stdout.flush()
    await asyncio.gather(*going)


if __name__ == "__main__":
    asyncio.run(load(sys.argv[1]))
