"""The page's own files served beside what is no cell but looks like one, for a real browser."""

from __future__ import annotations

import contextlib
import math
from typing import Any, AsyncIterator, Dict, List, Mapping, Union

import numpy as np
from aiohttp import web

from yarm.commander.requests import Situation
from yarm.commander.states import STATE_DOCS, State
from yarm.console.buttons import buttons
from yarm.console.cell import Cell, Part
from yarm.console.film import Film, unpack
from yarm.console.params import ConsoleParams
from yarm.console.picture import Area, BodyDrawing, CameraDrawing, Line, Scene, state_message
from yarm.console.server import ConsoleServer, Live
from yarm.console.wire import decode, encode
from yarm.geometry import CellMap, GridSpec, MappedObject, SeenPiece, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.records import plain
from yarm.resources import resource

TOKEN = "right-token-right-token-right"
STILL = (0.0, 0.0, 0.0, 1.0)
UNPAINTED = """
for (const name of ["Elements", "Arrays", "ElementsInstanced", "ArraysInstanced", "RangeElements"]) {
  WebGL2RenderingContext.prototype[`draw${name}`] = () => {};
}
"""
"""A page that runs this first gives WebGL everything, and nothing is painted: that is quick without a graphics card."""
SMALL_PX = (320, 240)


class FilmView:
    """Shows a film as if it were live, and again from its beginning when it is over."""

    def __init__(self, film: Film) -> None:
        """At its beginning."""
        index = film.index()
        entries = [entry for i in range(len(index["blocks"])) for entry in unpack(film.block(i) or b"")]
        self._entries = [(decode(message)[0]["kind"], message) for _, message in entries]
        self._at, self._made = 0, 0
        self._parts: Dict[str, Part] = {}

    def now_s(self) -> float:
        """A tenth of a second a picture, on and on."""
        return 0.1 * self._made

    def parts(self) -> Mapping[str, Part]:
        """The newest of each."""
        return dict(self._parts)

    def state(self) -> bytes:
        """The next."""
        self._made += 1
        while True:
            kind, message = self._entries[self._at]
            self._at = (self._at + 1) % len(self._entries)
            if kind == "state":
                return message
            self._parts[kind] = Part(self._made, message)


class BusyCellView:
    """A cell in which, when it is ``busy``, all is another in every picture: robots, cells, ways, debris, events."""

    def __init__(self, busy: bool = True) -> None:
        """At its beginning."""
        self._busy, self._made = busy, 0

    def now_s(self) -> float:
        """A tenth of a second a picture, on and on."""
        return 0.1 * self._made

    @property
    def _step(self) -> int:
        return self._made if self._busy else 0

    def _scene(self) -> Scene:
        body = Solid(Shape.CYLINDER, (0.3, 0.5), transform_matrix((0.0, 0.0, 0.25), STILL))
        piece = f"debris_{self._step // 10}"
        return Scene(
            [
                BodyDrawing("ankurbot_1", "Mobile", "dynamic", "base", [("base", body)]),
                BodyDrawing(piece, "Debris", "dynamic", "piece"),
            ],
            [CameraDrawing(f"camera {n}", f"camera_{n}", f"camera_{n}", 0.5, 0.5) for n in range(1, 5)],
            [Area("hc10_barc", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.02))],
        )

    def parts(self) -> Mapping[str, Part]:
        """Another piece of debris every ten pictures, and a line of events for each."""
        version = self._step // 10
        said = [
            {"time_s": float(n), "level": "warning", "node": "commander", "text": f"line {n} of what it says"}
            for n in range(max(0, version - 3), version + 1)
        ]
        node = {"name": "commander", "alive": True, "share": 0.1, "memory_mb": 80.0 + version % 7}
        beat = {"rate_hz": 10.0, "p50_ms": 3.0, "p99_ms": 9.0, "topic": "commander/status"}
        cameras = {"name": "merge_clouds: cameras", "level": "warning", "text": "camera_2: blind: 3 % of its points"}
        cameras["values"] = [[f"camera_{n} silent for, s", "0.033"] for n in range(1, 4)]
        health = {"kind": "health", "nodes": [{**node, "beat": beat}], "said": [cameras]}
        return {
            "scene": Part(version, self._scene().message(version)),
            "events": Part(version, encode({"kind": "events", "events": said}, {})),
            "health": Part(version, encode(health, {})),
        }

    def state(self) -> bytes:
        """The next."""
        self._made += 1
        step, spec, scene = self._step, GridSpec(), self._scene()
        x, y = math.cos(0.1 * step), math.sin(0.1 * step)
        poses = {frame: (1.5 * n, 1.0, 2.0, *STILL) for n, frame in enumerate(scene.frames)}
        poses.update(base=(x, y, 0.0, *STILL), piece=(-0.4, 0.1 * (step % 5), 0.8, *STILL))
        spots = np.random.default_rng(step).uniform((-2.4, -2.4, 0.05), (2.4, 2.4, 1.2), (200 + step % 40, 3))
        objects = {"ankurbot_1": MappedObject("ankurbot_1", "Mobile", 0, (x, y, 0.9), STILL, spec.cells_inside(spots))}
        at, name = poses["piece"][:3], f"debris_{step // 10}"
        seen = SeenPiece(20, at, 0.0, 0.15, 0.06, (1, 3))
        objects[name] = MappedObject(name, "Debris", 1, at, STILL, spec.cells_inside(np.array([at])), seen)
        cell_map = CellMap(self.now_s(), spec, np.zeros(spec.shape, np.int8), objects)
        way = np.linspace((x, y, 0.9), (-0.4, 0.0, 0.9), 5 + step % 30)
        lines = [Line("path", "ankurbot_1", way), Line("driven", "ankurbot_1", way[::-1])]
        return state_message(self._words(), scene, step // 10, poses, cell_map, lines)

    def _words(self) -> Dict[str, Any]:
        now = Situation(State.MENU, busy=False, succeeded=True)
        task = {"goal": f"debris_{self._step // 10}", "kind": "Debris", "robot": "ankurbot_1", "status": "moving"}
        task = {**task, "left_m": 1.25, "reason": "nearest of those who are free"}
        more = {**task, "goal": "bin_1/ankurbot_1", "kind": "Bin", "status": "backing_out"}
        more["reason"] = "ankurbot_1 cannot stand with its end effector at bin_1/ankurbot_1 (29, 10) at any heading"
        robot = {"name": "ankurbot_1", "held": False, "clearance_m": 0.25, "nearest": "the table with its long name"}
        arm = {"name": "hc10_barc", "state": "scan to path", "sands": True, "moving": True, "enabled": False}
        arm = {**arm, "progress": 0.4, "reason": "ankurbot_1 too near"}
        return {
            "time_s": round(self.now_s(), 3),
            "silent": [],
            "commander": {
                "state": "MENU",
                "means": STATE_DOCS[State.MENU],
                "busy": False,
                "outcome": "succeeded",
                "reason": "",
            },
            "buttons": [plain(button) for button in buttons(now)],
            "tasks": [task, more],
            "stop": {"latched": False, "reason": ""},
            "robots": [robot],
            "arms": [arm],
            "servers": [{"name": "action server of ankurbot_1", "level": "error", "text": "silent for 4 s"}],
            "room": None,
            "real_time_factor": 1.0,
        }


@contextlib.asynccontextmanager
async def page_served(shown: Union[Live, Film], results: str, **params: Any) -> AsyncIterator[str]:
    """The address of the page, without its token; on loopback, on a free port unless one is given."""
    given = ConsoleParams(**{"port": 0, "results": results, **params})
    said: List[str] = []
    server = ConsoleServer(given, TOKEN, shown, resource("web"), said.append)
    runner = web.AppRunner(server.application(), access_log=None)
    await runner.setup()
    await web.TCPSite(runner, given.host, given.port, shutdown_timeout=1.0).start()
    try:
        yield f"http://{given.host}:{runner.addresses[0][1]}/"
    finally:
        await runner.cleanup()


def live(cell: Cell, view: Union[FilmView, BusyCellView]) -> Live:
    """A cell that is commanded, and the view of it."""
    return Live(cell, view)
