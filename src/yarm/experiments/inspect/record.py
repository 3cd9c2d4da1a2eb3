"""What one inspection round leaves behind: plain rows, free of ROS, each field with its unit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Mapping, Optional, Tuple

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import (
    ClearCostmaps,
    Drive,
    Event,
    Look,
    Outcome,
    Spin,
    Stage,
    Stand,
    Step,
    Verdict,
)
from yarm.inspection.readers import PictureRead
from yarm.tags.motifs import GreyImage
from yarm.tags.printed import printed_rejection
from yarm.tags.recogniser import Look as TagLook
from yarm.tags.report import Sighting

WORDS = {Drive: "drive", Spin: "spin", Look: "look", ClearCostmaps: "clear", Stand: "stand"}
"""The word of each order."""
SAME_FRAME = Pose2(0.0, 0.0)
"""The map is the world."""


@dataclass(frozen=True)
class PathRow:
    """Where the robot was at a time; about ten rows a second.

    Attributes:
        t_s: time since the start of the round.
        true_x: where the robot really was, world, metres.
        true_y: metres.
        true_yaw: rad.
        x: where it believed to be, map, metres; NaN while it did not know.
        y: metres.
        yaw: rad.
        doing: word of the order that stood.
        box: number of the box that the order was about; 0 for none.
    """

    t_s: float
    true_x: float
    true_y: float
    true_yaw: float
    x: float
    y: float
    yaw: float
    doing: str
    box: int


@dataclass(frozen=True)
class OrderRow:
    """An order and how it ended.

    Attributes:
        start_s: when it was given, since the start.
        end_s: when it ended.
        doing: its word.
        stage: of the round.
        box: that it was about; 0 for none.
        x: goal of a drive, map, metres; NaN for other orders.
        y: metres.
        yaw: rad.
        outcome: done or failed; busy for one that was taken back.
        reason: why it failed; empty otherwise.
    """

    start_s: float
    end_s: float
    doing: str
    stage: str
    box: int
    x: float
    y: float
    yaw: float
    outcome: str
    reason: str


@dataclass(frozen=True)
class TouchRow:
    """The robot came into contact with something.

    Attributes:
        t_s: time since the start.
        block: name of what was touched.
        x: where, world, metres.
        y: metres.
    """

    t_s: float
    block: str
    x: float
    y: float


@dataclass(frozen=True, eq=False)
class LookRecord:
    """One image that was looked at for a box.

    Attributes:
        t_s: time since the start.
        box: number of the box.
        robot: where the robot believed to be, map.
        image: (h, w) grey.
        look: what ours made of it; None for the report's.
        sightings: what the report made of it, a tag each; empty for ours.
        printed: whether the printed program's rules tell which of them count.
    """

    t_s: float
    box: int
    robot: Pose2
    image: GreyImage
    look: Optional[TagLook] = None
    sightings: Tuple[Sighting, ...] = ()
    printed: bool = False

    @staticmethod
    def of(t_s: float, read: PictureRead, printed: bool) -> LookRecord:
        """Of a picture that was read."""
        shot = read.shot
        return LookRecord(t_s, read.box, shot.robot, shot.picture, read.look, read.sightings, printed)

    def rejection(self, seen: Sighting) -> str:
        """Why a sighting does not count; empty when it does."""
        return printed_rejection(seen) if self.printed else seen.rejection


@dataclass(frozen=True)
class RoundInfo:
    """What a round is made of.

    Attributes:
        layout: its name.
        controller: who drives it: report or yarm.
        seed: of noise and light.
        mode: kinematic or physics.
        time_limit_s: home by then.
        detector: whose features the recognition matches.
    """

    layout: str
    controller: str
    seed: int
    mode: str
    time_limit_s: float
    detector: str


@dataclass(frozen=True, eq=False)
class RoundRecord:
    """What a round came to.

    Attributes:
        info: what it was made of.
        stage: where it ended: done, failed, or what it was at when it was cut off.
        reason: why, if it failed.
        end_s: when.
        boxes: as the round was told of them.
        truth: what is on each box, by its number: a tag from 1, or 0 for blank.
        verdicts: in visiting order.
        path: about ten rows a second, the last one of the end.
        orders: in the order they were given.
        touches: contacts, in order.
        looks: images, in order.
        events: of the round, in order.
        computing_s: processor seconds of deciding and recognising.
        map_in_world: pose of the map frame in the world.
    """

    info: RoundInfo
    stage: Stage
    reason: str
    end_s: float
    boxes: Tuple[Box, ...]
    truth: Mapping[int, int]
    verdicts: Tuple[Verdict, ...]
    path: Tuple[PathRow, ...]
    orders: Tuple[OrderRow, ...]
    touches: Tuple[TouchRow, ...]
    looks: Tuple[LookRecord, ...]
    events: Tuple[Event, ...]
    computing_s: float
    map_in_world: Pose2 = SAME_FRAME


class RoundRecorder:
    """Puts the record of a round together while it goes on; times on one clock, from its start."""

    def __init__(self) -> None:
        """Nothing has happened."""
        self._step: Optional[Step] = None
        self._began_s = 0.0
        self._path: List[PathRow] = []
        self._orders: List[OrderRow] = []
        self._touches: List[TouchRow] = []
        self._looks: List[LookRecord] = []
        self._events: List[Event] = []

    def passed(self, t_s: float, true: Pose2, believed: Optional[Pose2]) -> None:
        """Where the robot is now, world and map."""
        order, box = (self._step.order, self._step.box) if self._step is not None else (Stand(), 0)
        nowhere = (math.nan, math.nan, math.nan)
        place = nowhere if believed is None else (believed.x, believed.y, believed.yaw_rad)
        self._path.append(PathRow(t_s, true.x, true.y, true.yaw_rad, *place, WORDS[type(order)], box))

    def stepped(self, t_s: float, step: Step, outcome: Outcome, reason: str) -> None:
        """One pass of the round: how the order before stood, and what stands now."""
        self._events += step.events
        before = self._step
        if before is not None and before.order is step.order:
            return
        if before is not None and not isinstance(before.order, Stand):
            self._orders.append(_order_row((self._began_s, t_s), before, outcome, reason))
        self._step, self._began_s = step, t_s

    def touched(self, touch: TouchRow) -> None:
        """A contact."""
        self._touches.append(touch)

    def looked(self, look: LookRecord) -> None:
        """An image."""
        self._looks.append(look)

    def finish(
        self,
        info: RoundInfo,
        end: Tuple[float, Stage, str],
        boxes: Tuple[Box, ...],
        truth: Mapping[int, int],
        verdicts: Tuple[Verdict, ...],
        computing_s: float,
        map_in_world: Pose2 = SAME_FRAME,
    ) -> RoundRecord:
        """The record of a round that ended at a time, in a stage, for a reason."""
        end_s, stage, reason = end
        return RoundRecord(
            info,
            stage,
            reason,
            end_s,
            boxes,
            truth,
            verdicts,
            tuple(self._path),
            tuple(self._orders),
            tuple(self._touches),
            tuple(self._looks),
            tuple(self._events),
            computing_s,
            map_in_world,
        )


def _order_row(span_s: Tuple[float, float], step: Step, outcome: Outcome, reason: str) -> OrderRow:
    order = step.order
    goal = (math.nan, math.nan, math.nan)
    if isinstance(order, Drive):
        goal = (order.goal.x, order.goal.y, order.goal.yaw_rad)
    return OrderRow(*span_s, WORDS[type(order)], str(step.stage), step.box, *goal, outcome.value, reason)
