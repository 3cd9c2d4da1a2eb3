"""The console's server: the page, the pictures it gets and the commands it gives; without ROS."""

from __future__ import annotations

import asyncio
import json
import secrets
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, AsyncIterator, Callable, Dict, NamedTuple, Optional, Tuple, Union

from aiohttp import web

from yarm.commander.requests import Request
from yarm.console.archive import Archive
from yarm.console.cell import Answer, Cell, View
from yarm.console.files import Files
from yarm.console.film import Film
from yarm.console.guard import BODY_BYTES, Guard, cookie_name, refusal
from yarm.console.pages import Filming, Pages
from yarm.console.params import ConsoleParams
from yarm.console.results import Results

CONFIRM_S = 10.0
"""A release is to be confirmed within this time, s."""
WORKERS = 4
LONGEST_SUBJECT = 100
RECORDED = "this is a recorded run: nothing can be asked of it"
COMMANDS: Dict[str, Dict[str, type]] = {
    "check": {},
    "state": {"next_state": bool, "current_state": bool, "previous_state": bool, "jump_state": int},
    "stop": {},
    "release": {"confirm": str},
}
"""Fields that each command may have, with their types."""


class BadRequestError(ValueError):
    """A command's body means nothing; the message says what is expected."""


class Live(NamedTuple):
    """A running system: what commands go to, and what pages show."""

    cell: Cell
    view: View


class ConsoleServer:
    """Ties the page's requests to a cell and a view."""

    def __init__(
        self,
        params: ConsoleParams,
        token: str,
        shown: Union[Live, Film],
        root: Path,
        warn: Callable[[str], None],
    ) -> None:
        """Set up; ``application`` is what runs.

        Args:
            params: address, rates, limits.
            token: what commands need.
            shown: a running system, or a recorded run, which takes no commands.
            root: folder of the page.
            warn: takes a line about each command and each refusal.
        """
        self._params, self._token, self._warn = params, token, warn
        self._guard = Guard(params.host, token, warn)
        self._files = Files(root)
        self._cell = shown.cell if isinstance(shown, Live) else None
        self._pages: Optional[Pages] = None
        film: Optional[Film] = None
        if isinstance(shown, Film):
            film = shown
        elif params.film_s > 0.0:
            film = Film("the last minutes", params.film_s)
        if isinstance(shown, Live):
            filming = None if film is None else Filming(film, 1.0 / params.film_hz)
            self._pages = Pages(shown.view, params.rate_hz, warn, filming)
        self._about = {"live": isinstance(shown, Live), "title": "" if film is None else film.title}
        self._archive = Archive(film, Results(Path(params.results).absolute()), self._files.headers)
        self._workers = ThreadPoolExecutor(WORKERS, "console")
        self._stopper = ThreadPoolExecutor(1, "console-stop")
        self._confirm: Tuple[str, float] = ("", 0.0)

    def application(self) -> web.Application:
        """The aiohttp application."""
        app = web.Application(middlewares=[self._guard.middleware], client_max_size=BODY_BYTES)
        app.router.add_get("/about", self._tell)
        if self._pages is not None:
            app.router.add_get("/live", self._pages.live)
        app.router.add_post("/command/{name}", self._command)
        app.router.add_post("/ask/why", self._why)
        self._archive.add_to(app)
        app.router.add_get("/{path:.*}", self._page)
        app.cleanup_ctx.append(self._running)
        return app

    async def _running(self, app: web.Application) -> AsyncIterator[None]:
        pictures = None if self._pages is None else asyncio.ensure_future(self._pages.run())
        yield
        if self._pages is not None and pictures is not None:
            pictures.cancel()
            await self._pages.close()
        self._workers.shutdown(wait=False)
        self._stopper.shutdown(wait=False)

    async def _tell(self, _: web.Request) -> web.StreamResponse:
        return web.json_response(self._about, headers=self._files.headers)

    async def _page(self, request: web.Request) -> web.StreamResponse:
        """A file; an address with the token in it becomes a cookie and an address without it."""
        if not self._guard.open_to_look and "token" in request.query:
            moved = web.HTTPFound(f"/#token={self._token}")
            moved.set_cookie(cookie_name(request), self._token, httponly=True, samesite="Strict", path="/")
            raise moved
        return await self._files.get(request)

    async def _why(self, request: web.Request) -> web.StreamResponse:
        try:
            body = await body_of(request, {"subject": str})
        except BadRequestError as error:
            return refusal(400, str(error))
        subject = body.get("subject", "")
        if not 0 < len(subject) <= LONGEST_SUBJECT:
            return refusal(400, f"subject must have 1 to {LONGEST_SUBJECT} characters, it has {len(subject)}")
        cell = self._cell
        if cell is None:
            return refusal(409, RECORDED)
        return await self._answer("why", lambda: cell.why(subject), self._workers)

    async def _command(self, request: web.Request) -> web.StreamResponse:
        """Each command that there is; the token has been looked at."""
        name = request.match_info["name"]
        allowed = COMMANDS.get(name)
        if allowed is None:
            return refusal(404, f"no command {name!r}; there are {', '.join(COMMANDS)}")
        try:
            body = await body_of(request, allowed)
        except BadRequestError as error:
            if name != "stop":
                return refusal(400, str(error))
            body = {}
        if name == "check":
            return web.json_response({"success": True, "message": "the token is right"})
        self._warn(
            f"command {name} {json.dumps({k: v for k, v in body.items() if k != 'confirm'})} from {request.remote}"
        )
        return refusal(409, RECORDED) if self._cell is None else await self._do(self._cell, name, body)

    async def _do(self, cell: Cell, name: str, body: Dict[str, Any]) -> web.StreamResponse:
        if name == "stop":
            self._confirm = ("", 0.0)
            return await self._answer("stop", cell.stop, self._stopper)
        if name == "release":
            return await self._release(cell, body.get("confirm", ""))
        return await self._answer("state", lambda: cell.change_state(Request(**body)), self._workers)

    async def _release(self, cell: Cell, confirm: str) -> web.StreamResponse:
        """The first step gives a word that the second must bring, soon."""
        word, until_s = self._confirm
        now_s = time.monotonic()
        if not confirm:
            self._confirm = (secrets.token_urlsafe(8), now_s + CONFIRM_S)
            text = f"confirm within {CONFIRM_S:g} s that everything may move again"
            return web.json_response({"success": True, "message": text, "confirm": self._confirm[0]})
        self._confirm = ("", 0.0)
        if not word or not secrets.compare_digest(confirm.encode(), word.encode()) or now_s > until_s:
            return refusal(409, f"not released: confirm within {CONFIRM_S:g} s of the first step; begin again")
        return await self._answer("release", cell.release, self._workers)

    async def _answer(self, name: str, call: Callable[[], Answer], pool: ThreadPoolExecutor) -> web.Response:
        """What the cell says, in time or not at all."""
        work = asyncio.get_running_loop().run_in_executor(pool, call)
        try:
            answer = await asyncio.wait_for(asyncio.shield(work), self._params.answer_s)
        except asyncio.TimeoutError:
            return refusal(
                504, f"{name}: no answer from the cell within {self._params.answer_s:g} s; look at its state"
            )
        return web.json_response({"success": answer.success, "message": answer.message})


async def body_of(request: web.Request, fields: Dict[str, type]) -> Dict[str, Any]:
    """A request's body.

    Args:
        request: with a JSON object of these fields, each of which may be left out.
        fields: their types.

    Raises:
        BadRequestError: it is something else.
    """
    known = ", ".join(f"{name} ({kind.__name__})" for name, kind in fields.items()) or "none"
    try:
        body: Optional[Any] = await request.json()
    except (ValueError, RecursionError) as error:
        raise BadRequestError(f"the body is no JSON: {error}") from error
    if not isinstance(body, dict):
        raise BadRequestError(f"the body must be an object; known fields: {known}")
    wrong = [name for name, value in body.items() if name not in fields or type(value) is not fields[name]]
    if wrong:
        raise BadRequestError(f"unknown or of a wrong type: {', '.join(map(repr, wrong))}; known fields: {known}")
    return body
