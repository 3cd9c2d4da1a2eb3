"""The report's explorer as its text describes it: one loop, the first behaviour in order that has something to say."""

from __future__ import annotations

from typing import Callable, List, Optional, Tuple

import numpy as np

from yarm.exploration.model import Command, Event, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.behaviours import (
    BumpRecovery,
    Deadline,
    FindExit,
    Forward,
    FullTurn,
    Selection,
    Stop,
    StuckWatch,
)
from yarm.exploration.report.frontier_mode import FrontierMode
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import View, Watcher


class ReportController:
    """Order: deadline, bumper, stuck or full turn, pause, frontier, find exit, selection, stop, forward."""

    def __init__(self, params: ExploreParams, seed: int, numbers: Optional[ReportParams] = None) -> None:
        """Draw from ``seed``; ``numbers`` are the report's own unless given."""
        self._deadline = Deadline(params.time_limit_s)
        self._params = numbers or ReportParams()
        rng = np.random.default_rng(seed)
        self._events: List[Event] = []
        self._watcher = Watcher(self._params.valid_range, True, self._params)
        self._selection = Selection(self._params, rng, self._events)
        self._bumper = BumpRecovery(self._params, self._selection)
        self._turn = FullTurn(self._params, self._selection)
        self._stuck = StuckWatch(self._params)
        self._frontier = FrontierMode(self._params, rng, self._events)
        self._exit = FindExit(self._params, self._selection)
        self._stop = Stop(self._params, self._selection)
        self._forward = Forward(self._params)

    def step(self, observation: Observation) -> Step:
        """One pass of the loop."""
        self._events.clear()
        rest = None if Deadline.name in self._params.off else self._deadline.step(observation.now_s)
        if rest is not None:
            return Step(rest, Deadline.name, done=True, reason="the time is over")
        view = self._watcher.look(observation)
        if view is None:
            return Step(behaviour="waiting", reason="no scan or no odometry yet")
        name, command = self._decide(view)
        self._stuck.add(view, command)
        return Step(command, name, tuple(self._events), intent=self._frontier.intent)

    def _decide(self, view: View) -> Tuple[str, Command]:
        """The first behaviour in order, among those that are on, that has something to say."""
        order: Tuple[Tuple[str, str, Callable[[View], Optional[Command]]], ...] = (
            ("bumper", "bumper", self._back_off),
            ("stuck", "stuck", self._free),
            ("full_turn", "full_turn", self._turn_when_due),
            ("full_turn", "", self._turn.step),
            ("pause", "", self._turn.pause),
            ("frontier", "frontier", self._to_frontier),
            ("find_exit", "find_exit", self._exit.step),
            ("selection", "", self._selection.step),
            ("forward", "stop", self._stop.step),
            ("forward", "forward", self._forward.step),
        )
        for name, switch, step in order:
            command = None if switch in self._params.off else step(view)
            if command is not None:
                return name, command
        return "stand", Command()

    def _back_off(self, view: View) -> Optional[Command]:
        if any(event.pressed for event in view.observation.bumps):
            self._frontier.bumped(view)
        return self._bumper.step(view)

    def _free(self, view: View) -> None:
        """A stuck robot turns once around, backing."""
        if not self._turn.active and self._stuck.stuck(view):
            self._events.append(Event(view.now_s, "stuck"))
            self._turn.begin()

    def _turn_when_due(self, view: View) -> None:
        if self._turn.due(view):
            self._turn.begin()

    def _to_frontier(self, view: View) -> Optional[Command]:
        command = self._frontier.step(view)
        if command is not None:
            self._selection.cancel()
        return command
