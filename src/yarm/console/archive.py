"""What a page is given of the past: films, and the results of runs; for looking only."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any, Callable, Dict, Optional, Tuple, TypeVar

from aiohttp import web

from yarm.console.film import Film, FilmError
from yarm.console.guard import refusal
from yarm.console.results import PROOF, ResultError, Results

T = TypeVar("T")
TYPES = {".png": "image/png", ".csv": "text/plain", ".log": "text/plain", ".html": "text/html"}
SHEET_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
)
"""Of a proof sheet: it may show what it brings, and reach nothing, this server neither."""


class Archive:
    """Serves one film (the last minutes, or a recorded run) and the results of a folder."""

    def __init__(self, film: Optional[Film], results: Results, headers: Dict[str, str]) -> None:
        """Nothing is read yet.

        Args:
            film: what ``/film`` gives; None for none.
            results: what ``/results`` gives.
            headers: of each answer.
        """
        self._film, self._results, self._headers = film, results, headers
        self._shown: Tuple[Optional[Path], float, Optional[Film]] = (None, 0.0, None)
        self._one = asyncio.Lock()

    def add_to(self, app: web.Application) -> None:
        """Its addresses."""
        app.router.add_get("/film", self._index)
        app.router.add_get("/film/{number:[0-9]{1,9}}", self._block)
        app.router.add_get("/results", self._runs)
        app.router.add_get("/results/{run:.+}/file/{file}", self._file)
        app.router.add_get("/results/{run:.+}/film", self._index)
        app.router.add_get("/results/{run:.+}/film/{number:[0-9]{1,9}}", self._block)
        app.router.add_get("/results/{run:.+}/summary", self._run)

    async def _index(self, request: web.Request) -> web.StreamResponse:
        film, fault = await self._film_of(request)
        return self._json(film.index()) if film is not None else refusal(404, fault)

    async def _block(self, request: web.Request) -> web.StreamResponse:
        film, fault = await self._film_of(request)
        if film is None:
            return refusal(404, fault)
        data = await _aside(lambda: film.block(int(request.match_info["number"])))
        if data is None:
            return refusal(404, "this part of the film is gone, or not there yet")
        return web.Response(body=data, content_type="application/octet-stream", headers=self._headers)

    async def _runs(self, _: web.Request) -> web.StreamResponse:
        async with self._one:
            runs = await _aside(self._results.runs)
        return self._json({"root": str(self._results.root), "runs": runs})

    async def _run(self, request: web.Request) -> web.StreamResponse:
        try:
            return self._json(await _aside(lambda: self._results.run(request.match_info["run"])))
        except ResultError as error:
            return refusal(404, str(error))

    async def _file(self, request: web.Request) -> web.StreamResponse:
        try:
            path = self._results.file(request.match_info["run"], request.match_info["file"])
        except ResultError as error:
            return refusal(404, str(error))
        if path is None:
            return refusal(404, "there is no such file, or it is of a kind that is not shown")
        headers = {**self._headers, "Content-Type": f"{TYPES[path.suffix]}; charset=utf-8"}
        if path.name == PROOF:
            headers["Content-Security-Policy"] = SHEET_POLICY
        return web.FileResponse(path, headers=headers)

    async def _film_of(self, request: web.Request) -> Tuple[Optional[Film], str]:
        """The film that is asked for; of recorded runs one at a time is kept."""
        name = request.match_info.get("run")
        if name is None:
            return self._film, "no film is kept here"
        async with self._one:
            try:
                path = self._results.film(name)
                if path is None:
                    return None, f"{name} has no film"
                written_s = path.stat().st_mtime
                if self._shown[:2] != (path, written_s):
                    self._shown = (path, written_s, await _aside(lambda: Film.read(path)))
            except (ResultError, FilmError, OSError) as error:
                return None, str(error)
            return self._shown[2], ""

    def _json(self, words: Any) -> web.Response:
        text = json.dumps(words, allow_nan=False, separators=(",", ":"))
        response = web.Response(text=text, content_type="application/json", headers=self._headers)
        response.enable_compression()
        return response


async def _aside(call: Callable[[], T]) -> T:
    """What a call gives that may take long, without holding anybody up."""
    return await asyncio.get_running_loop().run_in_executor(None, call)
