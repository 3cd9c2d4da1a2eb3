"""The report's printed main loop as it runs, faults included; blocking waits tick at the loop's rate.

The program is written as a generator: each ``yield`` publishes a command and waits for the next pass. A motion that
blocks in the program is a loop of its own here: it looks at scan and odometry, and at nothing else.
"""

from __future__ import annotations

import math
import sys
from typing import Generator, List, Optional, Sequence, Tuple

import numpy as np

from yarm.exploration.model import Command, Event, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.behaviours import TURN_RAD, to_more_room, to_the_middle
from yarm.exploration.report.frontiers import cropped
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.printed_follow import printed_follow
from yarm.exploration.report.printed_frontier import FRONTIER_AFTER_S, FRONTIER_CENTRE_M, printed_path
from yarm.exploration.report.view import View, Watcher
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import Bumper

FAR_M = 6.0
"""As far as this and more is too far."""
FAST_BEAM, FAST_BEYOND_M = 320, 0.69
FAST_MPS, SLOW_MPS = 0.2, 0.1
STOP_M, FREE_M = 0.5, 1.0
PLACE_M, PLACES = 0.19, 21
SELECT_RADPS, SEARCH_RADPS, SEARCH_S = math.pi / 8, math.pi / 6, 60.0
BUMP_MPS, BUMP_RADPS = 0.05, math.pi / 6
FRONT_COUNTER, FRONT_STEP = 100, 8
TURN_EVERY_S, TURN_FROM_S, TURN_RADPS, TURN_BACK_LOOPS, TURN_PAUSE_S = 101, 102.0, math.pi / 12, 10, 3.0
LIMIT_S = 900.0
STUCK_SAMPLES, STUCK_FROM_S = 300, 10.0
TURN_REST_RAD = 0.1

FAULTS = ("side_bump", "deaf", "full_turn", "open_space", "junction", "places")
"""What can be mended, one by one: a side bump ends after SIDE_LOOPS; selections and full turns hear the bumper, and
selections the deadline; there are no full turns; what is 6 m away or farther stops nobody as long as it is seen; a
strong turn is the strongest allowed, not none; places are remembered in the map, not in the odometry."""
SIDE_LOOPS = 10

Program = Generator[Tuple[str, Command], View, None]


class PrintedController:
    """Order: pause, full turn, its timer, front, left, right bumper, forward or angle selection."""

    def __init__(self, params: ExploreParams, seed: int, mended: Sequence[str] = ()) -> None:
        """The program's numbers are fixed, only the time it has is given.

        Args:
            params: how much time it has.
            seed: it draws from this.
            mended: which of FAULTS it has not got.

        Raises:
            ValueError: something else is to be mended.
        """
        unknown = sorted(set(mended) - set(FAULTS))
        if unknown:
            raise ValueError(f"faults {', '.join(unknown)} are not known; known: {', '.join(FAULTS)}")
        self._mended = frozenset(mended)
        self._far_m = sys.float_info.max if "open_space" in mended else FAR_M
        self._limit_s = min(params.time_limit_s, LIMIT_S)
        self._params = ReportParams()
        self._rng = np.random.default_rng(seed)
        self._watcher = Watcher(valid_m=math.inf, mend_single=False)
        self._events: List[Event] = []
        self._places: List[Tuple[float, float, int]] = []
        self._samples = 0
        self._front = 0
        self._left = False
        self._right = False
        self._side_loops = 0
        self._turning: Optional[float] = None
        self._turn_loops = 0
        self._pause_until = -math.inf
        self._heading: Optional[float] = None
        self._program: Optional[Program] = None

    def step(self, observation: Observation) -> Step:
        """One pass of the loop, or of a motion that blocks it."""
        self._events.clear()
        self._note_stuck(observation)
        for event in observation.bumps:
            self._latch(event.bumper, event.pressed)
        view = self._watcher.look(observation)
        if view is None:
            return Step(behaviour="waiting", reason="no scan or no odometry yet")
        try:
            if self._program is None:
                self._program = self._main(view)
                name, command = next(self._program)
            else:
                name, command = self._program.send(view)
        except StopIteration:
            return Step(Command(), "ended", (), True, "the time is over")
        return Step(command, name, tuple(self._events))

    def _note_stuck(self, observation: Observation) -> None:
        """The test that nothing listens to: its sums over the samples are never made, and a full window is stuck."""
        before, self._samples = self._samples, self._samples + int(observation.odometry is not None)
        if before < STUCK_SAMPLES <= self._samples and observation.now_s >= STUCK_FROM_S:
            self._events.append(Event(observation.now_s, "stuck", (("used", 0),)))

    def _latch(self, bumper: Bumper, pressed: bool) -> None:
        """A press is noted; nothing but the manoeuvre in front ever clears one."""
        if not pressed:
            return
        if bumper == Bumper.CENTER:
            self._front = FRONT_COUNTER
        elif bumper == Bumper.LEFT:
            self._left = True
        else:
            self._right = True

    def _main(self, view: View) -> Program:
        while view.now_s <= self._limit_s:
            if view.now_s < self._pause_until - 1e-6:
                view = yield "pause", Command()
            elif self._turning is not None:
                view = yield "full_turn", self._turn_on(view)
            elif self._timer_rings(view):
                self._turning, self._turn_loops = self._turned_since_heading(view), 0
            elif self._front > 0:
                view = yield from self._front_bump(view)
            elif self._left or self._right:
                view = yield "bumper", self._side_bump()
            else:
                view = yield from self._forward_or_select(view)

    def _timer_rings(self, view: View) -> bool:
        if "full_turn" in self._mended:
            return False
        second = math.floor(view.now_s + 1e-6)
        return second % TURN_EVERY_S == 1 and view.now_s >= TURN_FROM_S - 1e-6

    def _turned_since_heading(self, view: View) -> float:
        """What the full turn takes as turned already: from the heading last stored, however old."""
        if self._heading is None:
            return 0.0
        return (view.odom.yaw_rad - self._heading) % TURN_RAD

    def _turn_on(self, view: View) -> Command:
        """A pass of the full turn; bumpers are not looked at."""
        if self._is_called(view):
            self._turning = None
            return Command()
        self._turning = (self._turning or 0.0) + abs(view.turned_rad)
        self._turn_loops += 1
        if TURN_RAD - self._turning <= TURN_REST_RAD:
            self._turning = None
            self._pause_until = view.now_s + TURN_PAUSE_S
            return Command()
        return Command(-BUMP_MPS if self._turn_loops <= TURN_BACK_LOOPS else 0.0, TURN_RADPS)

    def _is_called(self, view: View) -> bool:
        """With that mended: whether a bump or the deadline ends what it does."""
        return "deaf" in self._mended and (self._front > 0 or self._left or self._right or view.now_s > self._limit_s)

    def _side_bump(self) -> Command:
        """A pass of backing off from a side; it is never the last one."""
        command = Command(-BUMP_MPS, -BUMP_RADPS if self._left else BUMP_RADPS)
        self._side_loops += 1
        if "side_bump" in self._mended and self._side_loops >= SIDE_LOOPS:
            self._left = self._right = False
            self._side_loops = 0
        return command

    def _front_bump(self, view: View) -> Generator[Tuple[str, Command], View, View]:
        """A pass of backing off; after the last one the angle selection, which blocks."""
        self._front -= FRONT_STEP
        if self._front > 0:
            view = yield "bumper", Command(-BUMP_MPS, BUMP_RADPS)
            return view
        self._front = 0
        view = yield from self._select(view, self._draw())
        return view

    def _draw(self) -> int:
        return 1 if self._rng.random() < self._params.left_share else -1

    def _forward_or_select(self, view: View) -> Generator[Tuple[str, Command], View, View]:
        centre = view.room.centre
        direction = self._draw()
        if view.now_s > FRONTIER_AFTER_S and centre == FRONTIER_CENTRE_M and view.observation.map is not None:
            view = yield from self._frontier(view, view.observation.map)
        if view.now_s > 1.0 and (centre <= STOP_M or centre >= self._far_m):
            direction, began = self._at_place(view, direction), view
            view = yield from self._select(view, direction)
            if view is began:  # exactly far_m ahead is too far to drive and no reason to turn: it stands for the pass
                view = yield "selection", Command()
            return view
        self._heading = view.odom.yaw_rad
        if not STOP_M < centre < self._far_m:
            view = yield "forward", Command()
            return view
        view = yield "forward", Command(self._speed(view), self._turn(view))
        return view

    def _turn(self, view: View) -> float:
        """While it drives."""
        if "junction" not in self._mended:
            return to_the_middle(view.room.left, view.room.right, self._params)
        most = self._params.middle_share * self._params.angular_max
        return max(-most, min(most, to_more_room(view.room.left, view.room.right, self._params)))

    @staticmethod
    def _frontier(view: View, room: GridMap) -> Generator[Tuple[str, Command], View, View]:
        """The frontier mode, if it were ever called; it blocks."""
        path, small = printed_path(room, view.odom), cropped(room)
        if path is None or small is None:
            return view
        view = yield from printed_follow(view, small.centres_of(path), small.resolution_m)
        return view

    @staticmethod
    def _speed(view: View) -> float:
        """By one beam; too near to be seen counts as far."""
        scan = view.observation.scan
        if scan is None or len(scan.ranges) <= FAST_BEAM:
            return SLOW_MPS
        beam = float(scan.ranges[::-1][FAST_BEAM])
        beam = math.inf if beam < scan.range_min_m else beam
        return FAST_MPS if beam > FAST_BEYOND_M else SLOW_MPS

    def _at_place(self, view: View, direction: int) -> int:
        """The other way at the first remembered place that this is; the place and the way are stored."""
        here = view.observation.pose if "places" in self._mended else None
        here = here or view.odom
        for x, y, before in self._places:
            if abs(here.x - x) <= PLACE_M and abs(here.y - y) <= PLACE_M:
                direction = -before
                break
        self._places.append((here.x, here.y, direction))
        del self._places[:-PLACES]
        return direction

    def _select(self, view: View, direction: int) -> Generator[Tuple[str, Command], View, View]:
        """Angle selection: blocks, and hears neither bumper nor deadline."""
        turned, centre = 0.0, view.room.centre
        self._events.append(Event(view.now_s, "draw", (("way", "left" if direction > 0 else "right"),)))
        while not self._is_called(view) and (self._no_way(centre) or abs(turned - math.pi) <= math.radians(30.0)):
            if TURN_RAD - turned <= TURN_REST_RAD:
                view = yield from self._search(view, direction)
                break
            view = yield "selection", Command(0.0, direction * SELECT_RADPS)
            turned += abs(view.turned_rad)
            centre = view.room.centre
        self._heading = view.odom.yaw_rad
        return view

    def _search(self, view: View, direction: int) -> Generator[Tuple[str, Command], View, View]:
        """After a whole turn: on while it grows, is too near or too far, for a minute at most; blocks as well."""
        began, last = view.now_s, -math.inf
        while (view.room.centre > last or self._no_way(view.room.centre)) and view.now_s - began < SEARCH_S:
            if self._is_called(view):
                break
            last = view.room.centre
            view = yield "selection", Command(0.0, direction * SEARCH_RADPS)
        return view

    def _no_way(self, centre_m: float) -> bool:
        return centre_m < FREE_M or centre_m > self._far_m
