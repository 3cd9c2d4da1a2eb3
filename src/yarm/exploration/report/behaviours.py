"""The report's behaviours but the frontier mode: each sets one command at a pass, or leaves it to the next in order."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np

from yarm.exploration.model import Command, Event
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import Track, View
from yarm.geometry import Pose2
from yarm.robots.turtlebot import Bumper

TURN_RAD = 2.0 * math.pi
LEFT, RIGHT = 1, -1


class Deadline:
    """Stands once the time is over."""

    name = "deadline"

    def __init__(self, limit_s: float) -> None:
        """Stand from this long after the start."""
        self._limit_s = limit_s

    def step(self, now_s: float) -> Optional[Command]:
        """Stand, or None while there is time left."""
        return Command() if now_s >= self._limit_s else None


class Direction:
    """Which way a selection turns: drawn, but at a place remembered the other way than there."""

    name = "places"

    def __init__(self, params: ReportParams, rng: np.random.Generator) -> None:
        """Draw from ``rng``."""
        self._params = params
        self._rng = rng
        self._places: List[Tuple[float, float, int]] = []

    def remembered(self, odom: Pose2) -> Optional[int]:
        """The direction taken at the first remembered place that this is; None elsewhere."""
        size = self._params.place_size
        near = (way for x, y, way in self._places if abs(odom.x - x) <= size and abs(odom.y - y) <= size)
        return next(near, None)

    def choose(self, odom: Pose2, store: bool) -> Tuple[int, bool]:
        """LEFT or RIGHT, and whether the place was remembered; ``store``: remember it with this direction."""
        before = self.remembered(odom)
        drawn = LEFT if self._rng.random() < self._params.left_share else RIGHT
        direction = drawn if before is None else -before
        if store and self.name not in self._params.off:
            self._places.append((odom.x, odom.y, direction))
            del self._places[: -self._params.places]
        return direction, before is not None


class Search:
    """After a whole turn without success: on to the next local maximum of the room ahead, for so long at most."""

    name = "search"

    def __init__(self, params: ReportParams) -> None:
        """Not begun."""
        self._params = params
        self._since_s: Optional[float] = None
        self._last_centre = math.inf

    @property
    def active(self) -> bool:
        """Whether the whole turn is over."""
        return self._since_s is not None

    def begin(self, now_s: float) -> None:
        """The whole turn is over now."""
        self._since_s = now_s

    def end(self) -> None:
        """Another selection begins."""
        self._since_s = None

    def look(self, view: View) -> None:
        """Note the room ahead, pass by pass."""
        self._last_centre = view.room.centre

    def found(self, view: View, roomy: bool) -> bool:
        """Whether it is to end here; switched off it ends at once."""
        late = self._since_s is None or view.now_s - self._since_s >= self._params.selection_limit
        return late or self.name in self._params.off or (roomy and view.room.centre <= self._last_centre)


class Selection:
    """Turns in place until there is room ahead."""

    name = "selection"

    def __init__(self, params: ReportParams, rng: np.random.Generator, events: List[Event]) -> None:
        """Draw directions from ``rng``; write draws to ``events``."""
        self._params = params
        self._events = events
        self._ways = Direction(params, rng)
        self._search = Search(params)
        self._direction = 0
        self._turned = 0.0

    @property
    def active(self) -> bool:
        """Whether it turns now."""
        return self._direction != 0

    def remembered(self, odom: Pose2) -> bool:
        """Whether a selection began here before."""
        return self._ways.remembered(odom) is not None

    def begin(self, view: View, store: bool) -> None:
        """Choose a direction; ``store``: remember the place, as for a selection that the laser asked for."""
        if self.name in self._params.off:
            return
        self._direction, again = self._ways.choose(view.odom, store)
        self._turned = 0.0
        self._search.end()
        way = "left" if self._direction == LEFT else "right"
        self._events.append(Event(view.now_s, "draw", (("way", way), ("again", int(again)))))

    def cancel(self) -> None:
        """End it, wherever it is."""
        self._direction = 0

    def step(self, view: View) -> Optional[Command]:
        """Turn on, or None when there is room ahead."""
        if not self.active:
            return None
        self._turned += abs(view.turned_rad)
        if not self._search.active and TURN_RAD - self._turned <= self._params.turn_rest:
            self._search.begin(view.now_s)
        if self._found(view):
            self.cancel()
            return None
        self._search.look(view)
        return Command(0.0, self._direction * self._params.selection_rate)

    def _found(self, view: View) -> bool:
        """Room ahead; nothing seen is none, since a wall may be too near to be seen."""
        centre = view.room.centre
        roomy = math.isfinite(centre) and centre >= self._params.selection_distance
        if self._search.active:
            return self._search.found(view, roomy)
        return roomy and abs(self._turned - math.pi) > self._params.selection_back


class BumpRecovery:
    """Backs off and turns away from what the bumper met; latched until done."""

    name = "bumper"

    def __init__(self, params: ReportParams, selection: Selection) -> None:
        """After a bump in front ``selection`` begins."""
        self._params = params
        self._selection = selection
        self._hit: Optional[Bumper] = None
        self._left = 0

    def step(self, view: View) -> Optional[Command]:
        """Back off, or None when it is done with."""
        pressed = [event.bumper for event in view.observation.bumps if event.pressed]
        if pressed:
            self._hit = Bumper.CENTER if Bumper.CENTER in pressed else pressed[0]
            self._left = self._params.bump_loops
            self._selection.cancel()
        if self._hit is None:
            return None
        if self._left == 0:
            front, self._hit = self._hit == Bumper.CENTER, None
            if front:
                self._selection.begin(view, store=False)
            return None
        self._left -= 1
        side = RIGHT if self._hit == Bumper.LEFT else LEFT
        return Command(-self._params.bump_speed, side * self._params.bump_turn)


class FullTurn:
    """A whole turn every so often, backing at first, then a pause."""

    name = "full_turn"

    def __init__(self, params: ReportParams, selection: Selection) -> None:
        """A turn that begins ends a ``selection``."""
        self._params = params
        self._selection = selection
        self._turned: Optional[float] = None
        self._loops = 0
        self._pause_until = -math.inf

    @property
    def active(self) -> bool:
        """Whether it turns now."""
        return self._turned is not None

    def begin(self) -> None:
        """Turn once around from here."""
        self._turned, self._loops = 0.0, 0
        self._selection.cancel()

    def due(self, view: View) -> bool:
        """Whether the clock asks for one."""
        second = math.floor(view.now_s + 1e-6) % math.floor(self._params.turn_period)
        return second == 1 and view.now_s >= self._params.turn_period + 1.0 - 1e-6 and not self.active

    def step(self, view: View) -> Optional[Command]:
        """Turn, or None when it is done with."""
        if self._turned is None:
            return None
        self._turned += abs(view.turned_rad)
        self._loops += 1
        if TURN_RAD - self._turned <= self._params.turn_rest:
            self._turned = None
            self._pause_until = view.now_s + self._params.turn_pause
            return None
        back = self._params.bump_speed if self._loops <= self._params.turn_backing else 0.0
        return Command(-back, self._params.turn_rate)

    def pause(self, view: View) -> Optional[Command]:
        """Stand for the pause after a turn."""
        return Command() if view.now_s < self._pause_until - 1e-6 else None


class StuckWatch:
    """Notices that the robot is told to move and hardly does."""

    name = "stuck"

    def __init__(self, params: ReportParams) -> None:
        """Look back on the window of the parameters."""
        self._params = params
        self._track = Track(params.stuck_window)

    def stuck(self, view: View) -> bool:
        """Whether it is; the window begins anew then."""
        if view.now_s < self._params.stuck_from:
            return False
        if not self._track.hardly_moved(self._params.stuck_path, self._params.stuck_turn):
            return False
        self._track.forget()
        return True

    def add(self, view: View, command: Command) -> None:
        """Note what was commanded at a pass."""
        self._track.add(view, command.v_mps, command.w_radps)


class FindExit:
    """Where a selection was made before and one side is much more open, it stops and selects again."""

    name = "find_exit"

    def __init__(self, params: ReportParams, selection: Selection) -> None:
        """Ask ``selection`` for the places, and to begin."""
        self._params = params
        self._selection = selection
        self._been_here = False

    def step(self, view: View) -> Optional[Command]:
        """Stop once at each visit to such a place."""
        here = self._selection.remembered(view.odom)
        entered, self._been_here = here and not self._been_here, here
        if not entered or self._selection.active:
            return None
        if abs(view.room.left - view.room.right) <= self._params.exit_difference:
            return None
        self._selection.begin(view, store=False)
        return Command()


class Stop:
    """Stops and selects a direction where there is no room ahead."""

    name = "stop"

    def __init__(self, params: ReportParams, selection: Selection) -> None:
        """Without room ``selection`` begins."""
        self._params = params
        self._selection = selection

    def step(self, view: View) -> Optional[Command]:
        """Stop and begin to select, or None with room ahead."""
        if has_room(view, self._params) or Selection.name in self._params.off:
            return None
        self._selection.begin(view, store=True)
        return Command()


class KeepToMiddle:
    """Turns towards the side with more room while it drives ahead."""

    name = "middle"

    def __init__(self, params: ReportParams) -> None:
        """Turn as the parameters say."""
        self._params = params

    def turn(self, view: View) -> float:
        """Turn, rad/s; none when it is switched off."""
        off = self.name in self._params.off
        return 0.0 if off else to_the_middle(view.room.left, view.room.right, self._params)


class Forward:
    """Drives ahead; slower near something."""

    name = "forward"

    def __init__(self, params: ReportParams) -> None:
        """Keep to the middle meanwhile."""
        self._params = params
        self._middle = KeepToMiddle(params)

    def step(self, view: View) -> Command:
        """Drive."""
        params = self._params
        fast = view.room.centre > params.slow_distance and has_room(view, params)
        return Command(params.speed if fast else params.slow_speed, self._middle.turn(view))


def has_room(view: View, params: ReportParams) -> bool:
    """Whether there is room ahead to drive on; nothing seen is none."""
    return math.isfinite(view.room.centre) and view.room.centre >= params.stop_distance


def to_the_middle(left_m: float, right_m: float, params: ReportParams) -> float:
    """Turn, rad/s, towards the side with more room; 0 once it reaches ``middle_share`` of the greatest turn."""
    turn = to_more_room(left_m, right_m, params)
    return 0.0 if abs(turn) >= params.middle_share * params.angular_max else turn


def to_more_room(left_m: float, right_m: float, params: ReportParams) -> float:
    """The same turn without that end."""
    return params.middle_gain * (min(left_m, params.nothing) - min(right_m, params.nothing))
