"""The report's behaviours but the frontier mode: each sets one command at a pass, or leaves it to the next in order."""

from __future__ import annotations

import math
from typing import List, Optional, Tuple

import numpy as np

from yarm.exploration.model import Command, Event
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import NOTHING_M, Track, View
from yarm.geometry import Pose2
from yarm.robots.turtlebot import Bumper

TURN_RAD = 2.0 * math.pi
TURN_REST_RAD = 0.1
"""A whole turn is done when less than this is left of it."""
BACK_RAD = math.radians(30.0)
"""A selection does not end within this of where the robot came from."""
LEFT, RIGHT = 1, -1


class Selection:
    """Turns in place until there is room ahead; remembers where it did so and which way it turned."""

    name = "selection"

    def __init__(self, params: ReportParams, rng: np.random.Generator, events: List[Event]) -> None:
        """Draw directions from ``rng``; write draws to ``events``."""
        self._params = params
        self._rng = rng
        self._events = events
        self._places: List[Tuple[float, float, int]] = []
        self._direction = 0
        self._turned = 0.0
        self._searching_since: Optional[float] = None
        self._last_centre = math.inf

    @property
    def active(self) -> bool:
        """Whether it turns now."""
        return self._direction != 0

    def remembered(self, odom: Pose2) -> Optional[int]:
        """The direction taken at the first remembered place that this is; None elsewhere."""
        size = self._params.place_size
        near = (way for x, y, way in self._places if abs(odom.x - x) <= size and abs(odom.y - y) <= size)
        return next(near, None)

    def begin(self, view: View, store: bool) -> None:
        """Choose a direction; ``store``: remember the place, as for a selection that the laser asked for."""
        before = self.remembered(view.odom)
        drawn = LEFT if self._rng.random() < self._params.left_share else RIGHT
        self._direction = drawn if before is None else -before
        self._turned, self._searching_since = 0.0, None
        if store:
            self._places.append((view.odom.x, view.odom.y, self._direction))
            del self._places[: -self._params.places]
        way = "left" if self._direction == LEFT else "right"
        self._events.append(Event(view.now_s, "draw", (("way", way), ("again", int(before is not None)))))

    def cancel(self) -> None:
        """End it, wherever it is."""
        self._direction = 0

    def step(self, view: View) -> Optional[Command]:
        """Turn on, or None when there is room ahead."""
        if not self.active:
            return None
        self._turned += abs(view.turned_rad)
        if self._searching_since is None and TURN_RAD - self._turned <= TURN_REST_RAD:
            self._searching_since = view.now_s
        if self._found(view):
            self.cancel()
            return None
        self._last_centre = view.room.centre
        return Command(0.0, self._direction * self._params.selection_rate)

    def _found(self, view: View) -> bool:
        """Room ahead; nothing seen is none, since a wall may be too near to be seen."""
        centre = view.room.centre
        roomy = math.isfinite(centre) and centre >= self._params.selection_distance
        if self._searching_since is None:
            return roomy and abs(self._turned - math.pi) > BACK_RAD
        late = view.now_s - self._searching_since >= self._params.selection_limit
        return late or (roomy and centre <= self._last_centre)


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
        return Command(-self._params.bump_speed, side * self._params.angular_max)


class FullTurn:
    """A whole turn every so often, backing at first, then a pause."""

    name = "full_turn"
    BACKING_LOOPS = 10

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
        if TURN_RAD - self._turned <= TURN_REST_RAD:
            self._turned = None
            self._pause_until = view.now_s + self._params.turn_pause
            return None
        back = self._params.bump_speed if self._loops <= self.BACKING_LOOPS else 0.0
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
        here = self._selection.remembered(view.odom) is not None
        entered, self._been_here = here and not self._been_here, here
        if not entered or self._selection.active:
            return None
        if abs(view.room.left - view.room.right) <= self._params.exit_difference:
            return None
        self._selection.begin(view, store=False)
        return Command()


class Forward:
    """Drives ahead, in the middle between what is left and right; stops and selects where there is no room."""

    name = "forward"

    def __init__(self, params: ReportParams, selection: Selection) -> None:
        """Without room ``selection`` begins."""
        self._params = params
        self._selection = selection

    def step(self, view: View) -> Command:
        """Drive, or stop and begin to select."""
        params, centre = self._params, view.room.centre
        blocked = centre < params.stop_distance or not math.isfinite(centre)
        if blocked and "selection" not in params.off:
            self._selection.begin(view, store=True)
            return Command()
        speed = params.speed if centre > params.slow_distance and not blocked else params.slow_speed
        return Command(speed, 0.0 if "middle" in params.off else self.to_the_middle(view))

    def to_the_middle(self, view: View) -> float:
        """Turn towards the side with more room, rad/s; a strong turn becomes none, as the program has it."""
        return to_the_middle(view.room.left, view.room.right, self._params)


def to_the_middle(left_m: float, right_m: float, params: ReportParams) -> float:
    """Turn, rad/s, towards the side with more room; 0 once it reaches two thirds of the greatest turn."""
    turn = params.middle_gain * (min(left_m, NOTHING_M) - min(right_m, NOTHING_M))
    return 0.0 if abs(turn) >= params.angular_max / 1.5 else turn
