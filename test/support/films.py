"""Films of made-up pictures."""

from __future__ import annotations

import numpy as np

from yarm.console.cell import Part
from yarm.console.film import Film, unpack
from yarm.console.wire import decode, encode


def state(time_s, cells=((1, 2, 3),)):
    arrays = {"poses": np.full((2, 7), time_s, np.float32), "cells": np.array(cells, np.uint8)}
    return encode({"kind": "state", "time_s": time_s}, arrays)


def scene(version):
    return Part(version, encode({"kind": "scene", "version": version}, {}))


def events(version, *texts):
    said = [{"time_s": float(i), "level": "info", "node": "n", "text": text} for i, text in enumerate(texts)]
    return Part(version, encode({"kind": "events", "events": said}, {}))


def taken(count, step_s=0.5, keep_s=float("inf")):
    film = Film("a run", keep_s)
    for i in range(count):
        film.add(i * step_s, {"scene": scene(i // 30)}, state(i * step_s))
    return film


def shown(film):
    """Time and header of every entry, block by block."""
    index = film.index()
    numbers = range(index["first"], index["first"] + len(index["blocks"]))
    return [[(time_s, decode(message)[0]) for time_s, message in unpack(film.block(n))] for n in numbers]
