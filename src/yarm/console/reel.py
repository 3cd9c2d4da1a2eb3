"""A film of tasks that are played in the simulation one after the other, each with a clock of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List, Mapping

import numpy as np

from yarm.console.cell import Part
from yarm.console.film import EVENTS, Film
from yarm.console.picture import Line
from yarm.console.results import FILM
from yarm.console.wire import encode
from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.motion.trajectory import Trajectory

PERIOD_S = 0.1
"""Simulated time between two pictures, s."""
GAP_S = 1.0
"""Between the last picture of a task and the first of the next, s."""
HAND = "hand"
WAY_POINTS = 40
"""Points of the hand's way in one motion."""
TRACE_M, TRACE_POINTS = 0.02, 3000
"""The hand's way behind: distance of two points, metres, and points at most; the oldest go."""


class Reel:
    """Takes the pictures of one task after the other into one film."""

    def __init__(self, title: str) -> None:
        """Nothing has been seen yet.

        Args:
            title: of the film, for people.
        """
        self.film = Film(title)
        self.task = 0
        self._begun_s = self._last_s = -GAP_S
        self._next_s = 0.0
        self._events: List[Dict[str, Any]] = []

    def begin(self, words: str) -> int:
        """Another task, whose clock begins at 0 s; its number, from 1 on."""
        self.task += 1
        self._begun_s, self._next_s = self._last_s + GAP_S, 0.0
        self.say(0.0, words)
        return self.task

    def say(self, time_s: float, words: str) -> None:
        """Something has happened, at a time of the task, s."""
        self._events.append({"time_s": self.at_s(time_s), "level": "info", "node": "youbot", "text": words})

    def at_s(self, time_s: float) -> float:
        """A time of the task in the film, s."""
        return round(self._begun_s + time_s, 3)

    def due(self, time_s: float) -> bool:
        """Whether it is time for a picture, at a time of the task, s; the next one is due later."""
        if time_s < self._next_s:
            return False
        self._next_s = time_s + PERIOD_S
        return True

    def add(self, time_s: float, parts: Mapping[str, Part], state: bytes) -> None:
        """A picture, at a time of the task, s."""
        events = Part(len(self._events), encode({"kind": EVENTS, "events": self._events}, {}))
        self._last_s = self.at_s(time_s)
        self.film.add(self._last_s, {**parts, EVENTS: events}, state)

    def write(self, folder: Path) -> Path:
        """The film as a file of a run's folder.

        Raises:
            OSError: it cannot be written.
        """
        self.film.write(folder / FILM)
        return folder / FILM


class HandTrace:
    """Where the hand has been."""

    def __init__(self) -> None:
        """Nowhere yet."""
        self._points: List[FloatArray] = []

    def follow(self, place: FloatArray) -> None:
        """It is at a place, (3,) metres, world."""
        if not self._points or np.linalg.norm(place - self._points[-1]) >= TRACE_M:
            self._points = [*self._points[1 - TRACE_POINTS :], place]

    def lines(self) -> List[Line]:
        """Its way behind; none before it has moved."""
        return [Line("driven", HAND, np.array(self._points))] if len(self._points) > 1 else []


def hand_way(motion: Trajectory) -> FloatArray:
    """The hand's way in a motion, (n, 3), metres, the arm's frame."""
    q, _, _ = motion.evaluate(np.linspace(0.0, motion.duration_s, WAY_POINTS))
    return np.asarray(forward_many(q)[:, :3, 3])


def words_of(time_s: float, title: str, facts: List[List[str]]) -> Dict[str, Any]:
    """What a picture says beside its arrays, where there is no Commander: facts as names and values."""
    return {
        "time_s": time_s,
        "silent": [],
        "commander": None,
        "buttons": [],
        "tasks": [],
        "stop": None,
        "robots": [],
        "arms": [],
        "real_time_factor": None,
        "room": {"title": title, "facts": facts, "verdicts": []},
    }


def in_degrees(joints: FloatArray) -> str:
    """Joints, rad, for people."""
    return ", ".join(f"{round(float(np.degrees(angle)))}\u00b0" for angle in joints)
