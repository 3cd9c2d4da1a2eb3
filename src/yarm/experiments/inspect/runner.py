"""Runs a round in the kinematic world at 10 Hz: orders carried out, pictures taken, everything noted."""

from __future__ import annotations

import math
import time
from dataclasses import asdict
from typing import Any, Dict, Optional, Tuple, Union

import numpy as np

from yarm.experiments.inspect.eyes import Camera, Eyes, Moment, boxes_of, make_eyes
from yarm.experiments.inspect.pilot import ARRIVE_RAD, Pilot, Ways, known_map
from yarm.experiments.inspect.record import RoundInfo, RoundRecord, RoundRecorder, TouchRow
from yarm.experiments.inspect.switched_eyes import StillCamera, switched_eyes, with_strangers
from yarm.experiments.inspect.switched_round import SwitchedRound
from yarm.experiments.inspect.switches import LOOSE_RAD, Switches
from yarm.geometry import Pose2
from yarm.inspection.model import (
    CONTROLLERS,
    OURS,
    PRINTED,
    REPORT,
    ClearCostmaps,
    Drive,
    Look,
    Observation,
    Order,
    Outcome,
    Reading,
    Spin,
    Stage,
    Stand,
    Step,
)
from yarm.inspection.printed_round import PrintedRound
from yarm.inspection.reading import chances
from yarm.inspection.report_round import ReportRound, ReportRoundParams
from yarm.inspection.round import Round, RoundParams
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.layout import Layout
from yarm.tags.chance import LookChance
from yarm.tags.features import DETECTOR

TICK_S = 0.1
LIMIT_S = 480.0
AFTER_S = 120.0
"""A round that is late is watched so long after the limit."""
PLACE_M, PLACE_RAD, PLACE_S = 0.014, math.radians(0.3), 2.0
"""Deviation of the localisation's error, each way, and how long it stays alike; measured in bench/localisation.md."""
CLEARING_S = 1.0
"""What forgetting costmaps takes."""
NOTHING = Switches()
AnyRound = Union[Round, ReportRound]


class _Place:
    """Where the localisation believes the robot to be: the truth, and an error that changes slowly."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._error = rng.standard_normal(3)

    def believed(self, true: Pose2) -> Pose2:
        keep = math.exp(-TICK_S / PLACE_S)
        self._error = keep * self._error + math.sqrt(1.0 - keep**2) * self._rng.standard_normal(3)
        x, y, yaw = self._error * (PLACE_M, PLACE_M, PLACE_RAD)
        return Pose2(true.x + float(x), true.y + float(y), true.yaw_rad + float(yaw))


class _Player:
    """Carries out one order after the other."""

    def __init__(self, layout: Layout, eyes: Eyes, ways: Ways, seed: int, switches: Switches) -> None:
        self.world = KinematicWorld(layout.arena, seed)
        self._place = _Place(np.random.default_rng((seed, 11)))
        self._eyes = eyes
        self._pilot = Pilot(ways, TICK_S, LOOSE_RAD if switches.loose_heading else ARRIVE_RAD)
        self._order: Order = Stand()
        self._began_s = 0.0
        self._turned = 0.0
        self._images = 0
        self._fault = ""
        self.believed = self._place.believed(self.world.truth)
        self._goal = self.believed

    def take(self, order: Order, now_s: float) -> None:
        """A new order."""
        if order is self._order:
            return
        self._order, self._began_s, self._turned, self._images, self._fault = order, now_s, 0.0, 0, ""
        self._pilot.stop()
        if isinstance(order, Drive):
            self._goal = order.goal
            self._fault = self._pilot.go(self.believed, order.goal)

    def tick(self, now_s: float) -> Tuple[Outcome, str, Optional[Reading]]:
        """A tenth of a second of the order; how it stands after it."""
        found = self._carry_out(now_s)
        self.believed = self._place.believed(self.world.truth)
        return found

    def _carry_out(self, now_s: float) -> Tuple[Outcome, str, Optional[Reading]]:
        order = self._order
        if isinstance(order, Drive):
            return (*self._drive(order, now_s), None)
        if isinstance(order, Spin):
            self.world.step(0.0, math.copysign(order.rate_radps, order.angle_rad), TICK_S)
            self._turned += order.rate_radps * TICK_S
            return (Outcome.DONE if self._turned >= abs(order.angle_rad) else Outcome.BUSY), "", None
        self.world.step(0.0, 0.0, TICK_S)
        if isinstance(order, Look):
            return self._look(order, now_s)
        waited = now_s + TICK_S - self._began_s >= CLEARING_S
        return (Outcome.DONE if waited or not isinstance(order, ClearCostmaps) else Outcome.BUSY), "", None

    def _drive(self, order: Drive, now_s: float) -> Tuple[Outcome, str]:
        if self._fault:
            self.world.step(0.0, 0.0, TICK_S)
            return Outcome.FAILED, self._fault
        if now_s - self._began_s > order.limit_s:
            self.world.step(0.0, 0.0, TICK_S)
            return Outcome.FAILED, f"not there after {order.limit_s:.0f} s"
        v, w, arrived = self._pilot.step(self.believed, self.world)
        self.world.step(v, w, TICK_S)
        return (Outcome.DONE if arrived else Outcome.BUSY), ""

    def _look(self, order: Look, now_s: float) -> Tuple[Outcome, str, Optional[Reading]]:
        if now_s + TICK_S - self._began_s < (self._images + 1) * (TICK_S + order.pause_s) - 1e-6:
            return Outcome.BUSY, "", None
        self._images += 1
        moment = Moment(now_s + TICK_S, self.world.truth, self.believed, self.world.scan(), self._goal)
        reading = self._eyes.look(order, moment)
        late = now_s + TICK_S - self._began_s >= order.limit_s
        if reading is None and self._images < order.images and not late:
            return Outcome.BUSY, "", None
        return Outcome.DONE, "", reading or self._eyes.reading(order.box)


def run_round(layout: Layout, controller: str, seed: int, switches: Switches = NOTHING) -> RoundRecord:
    """One round in a layout.

    Args:
        layout: boxes and tags.
        controller: one of CONTROLLERS.
        seed: of noise and light.
        switches: known faults of the report's program; only for its round.

    Raises:
        ValueError: no such controller.
    """
    if switches != NOTHING and controller != REPORT:
        raise ValueError(f"controller {controller!r} has none of the report's faults to switch on")
    if controller not in CONTROLLERS:
        raise ValueError(f"controller {controller!r} is not known; known: {', '.join(CONTROLLERS)}")
    if switches.strangers:
        layout = with_strangers(layout)
    recorder = RoundRecorder()
    ways, camera = Ways(known_map(layout.arena)), (StillCamera if switches.frames_copied else Camera)(layout, seed)
    if controller == REPORT:
        eyes = switched_eyes(layout, camera, recorder.looked, switches)
    else:
        eyes = make_eyes(controller, layout, camera, recorder.looked)
    tour = _round(layout, controller, ways, switches)
    player = _Player(layout, eyes, ways, seed, switches)
    seen = Observation(0.0, player.believed, True)
    step = Step(Stand(), Stage.PLAN)
    ticks, deciding_s = 0, 0.0
    while ticks * TICK_S < LIMIT_S + AFTER_S:
        began = time.process_time()
        step = tour.step(seen)
        deciding_s += time.process_time() - began
        recorder.stepped(ticks * TICK_S, step, seen.outcome, seen.reason)
        recorder.passed(ticks * TICK_S, player.world.truth, player.believed)
        if isinstance(step.order, Stand):
            break
        player.take(step.order, ticks * TICK_S)
        outcome, reason, reading = player.tick(ticks * TICK_S)
        ticks += 1
        if switches.goals_ignored and outcome == Outcome.FAILED:
            outcome, reason = Outcome.DONE, ""
        seen = Observation(ticks * TICK_S, player.believed, True, outcome, reason, reading)
    for touch in player.world.touches:
        recorder.touched(TouchRow(touch.t_s, touch.block, touch.x, touch.y))
    return recorder.finish(
        RoundInfo(layout.arena.name, controller, seed, "kinematic", LIMIT_S, DETECTOR),
        (ticks * TICK_S, step.stage, step.reason),
        tuple(boxes_of(layout)),
        dict(enumerate(layout.tags, start=1)),
        tuple(tour.verdicts),
        deciding_s + eyes.computing_s,
    )


def parameters_of(controller: str) -> Dict[str, Any]:
    """Everything that can be set in a round of a controller, by the names of its parts."""
    if controller == OURS:
        return {"round": asdict(RoundParams()), "chance": asdict(LookChance())}
    return {"round": asdict(ReportRoundParams())}


def _round(layout: Layout, controller: str, ways: Ways, switches: Switches) -> AnyRound:
    boxes = boxes_of(layout)
    if controller == OURS:
        return Round(boxes, ways.lengths, chances(boxes, LookChance()), gap=ways.gap)
    blocks = FlatBoxes(layout.arena.blocks)
    asked = Ways(known_map(layout.arena, boxes=False)) if switches.empty_map else ways

    def gap(x: float, y: float) -> float:
        return float(blocks.distances(x, y).min())

    def plannable(start: Pose2, goal: Pose2) -> bool:
        begin = Pose2(0.0, 0.0) if switches.query_from_origin else start
        return math.isfinite(float(asked.lengths(begin, [goal])[0]))

    if controller == PRINTED:
        return PrintedRound(boxes, plannable)
    return SwitchedRound(boxes, plannable, gap, switches)
