"""A round in full physics without ROS: the inspector's session, move_base and the localisation, pass by pass.

The parts are those of the nodes, called one after the other ten times a second, as fast as the machine can.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Optional, Tuple

from yarm.experiments.inspect.eyes import Camera, boxes_of
from yarm.experiments.inspect.given import BY_HAND, FINE_CELL_M, room_map
from yarm.experiments.inspect.pilot import Ways
from yarm.experiments.inspect.record import LookRecord, RoundInfo, RoundRecord, RoundRecorder, TouchRow
from yarm.experiments.inspect.runner import AFTER_S, LIMIT_S, NOTHING
from yarm.experiments.inspect.switched_round import SwitchedRound
from yarm.experiments.inspect.switches import FAULTS_IN_PHYSICS, Switches
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.inspection.flow import RoundFlow
from yarm.inspection.model import CONTROLLERS, ENDS, OURS, PRINTED, REPORT, Look, Outcome, Stage
from yarm.inspection.printed_round import PrintedRound
from yarm.inspection.readers import Reader, make_reader
from yarm.inspection.reading import chances
from yarm.inspection.round import Round, RoundParams
from yarm.inspection.senses import Picture, Senses
from yarm.inspection.session import LOOP_S, InspectionSession, SessionParams, SessionStep
from yarm.inspection.start_place import fitted
from yarm.navigation.bodies import with_bodies
from yarm.navigation.follower import Drive
from yarm.navigation.low_obstacles import low_obstacles
from yarm.navigation.move_base import MoveBase, Observation, Status
from yarm.navigation.move_base_params import MoveBaseParams
from yarm.navigation.slam_native import Localiser
from yarm.sim.engine.physics_world import PhysicsWorld
from yarm.sim.room_robot import RoomRobot
from yarm.sim.scenes.layout import Layout
from yarm.tags.chance import LookChance
from yarm.tags.features import DETECTOR
from yarm.tags.pictures import shipped_pictures

DRIVING = MoveBaseParams(controller_frequency=1.0 / LOOP_S, xy_goal_tolerance=0.05, yaw_goal_tolerance=0.04)
"""As inspection.launch starts move_base."""
PLATFORM = MoveBaseParams()
"""As it starts move_base with ``platform_tolerances``, for the report's rounds: the platform's own numbers."""
OUTCOMES = {Status.SUCCEEDED: Outcome.DONE, Status.ABORTED: Outcome.FAILED}


class _Robot:
    """What the nodes around the inspector do: localise, drive to goals, take pictures."""

    def __init__(self, world: RoomRobot, layout: Layout, controller: str, seed: int, switches: Switches) -> None:
        self.world = world
        known = [] if switches.empty_map else [box.corners() for box in boxes_of(layout)]
        self.ways = Ways(with_bodies(room_map(layout), known))
        # As inspection.launch gives amcl its map (fine_map).
        fine = controller == OURS
        self._localiser = Localiser(with_bodies(room_map(layout, FINE_CELL_M), known) if fine else self.ways.grid)
        self._doubts_unheard = switches.doubts_unheard
        if controller != OURS:
            self._localiser.believe(layout.arena.start.compose(BY_HAND))
        driving = DRIVING if controller == OURS else PLATFORM
        self._base = MoveBase(driving)
        self._passes_a_step = round(driving.period_s / LOOP_S)
        self._passes = 0
        self._drive = Drive()
        self._camera = Camera(layout, seed)
        self._goal: Tuple[Outcome, str] = (Outcome.BUSY, "")

    def observe(self, now_s: float, looking: bool) -> Senses:
        """Everything known at a pass; a picture only for somebody who looks."""
        odometry, scan = self.world.odometry(), self.world.scan()
        place = self._localiser.add(odometry, scan)
        unheard = self._doubts_unheard and place.map_from_odom is not None
        picture = Picture(now_s, self._camera.picture(self.world.truth)) if looking else None
        return Senses(
            now_s,
            scan,
            odometry,
            place.map_from_odom,
            now_s,
            place.localised or unheard,
            "" if unheard else place.reason,
            picture,
            goal=self._goal,
        )

    def act(self, seen: Senses, step: SessionStep) -> None:
        """Do what the session says, and let a pass go by."""
        action = step.action
        if action.cancel:
            self._base.cancel()
            self._drive = Drive()
        if action.clear:
            self._base.clear_costmaps()
        if action.goal is not None:
            self._base.go(action.goal, seen.now_s)
            self._goal = (Outcome.BUSY, "")
        if self._passes % self._passes_a_step == 0:
            self._navigate(seen)
        self._passes += 1
        if action.turn_radps is not None:
            self.world.step(0.0, action.turn_radps, LOOP_S)
        else:
            self.world.step(self._drive.v_mps, self._drive.w_radps, LOOP_S)

    def _navigate(self, seen: Senses) -> None:
        """One step of move_base; its command stands until the next one."""
        moved = self._base.step(
            Observation(
                seen.now_s,
                seen.pose,
                seen.place_fault,
                seen.scan,
                seen.pose,
                self.ways.grid,
                bumps=self.world.take_bumps(),
                odometry=None if seen.odometry is None else seen.odometry.pose,
            )
        )
        if moved.status in OUTCOMES:
            self._goal = (OUTCOMES[moved.status], moved.reason)
        self._drive = moved.drive or Drive()

    def plannable(self, start: Pose2, goal: Pose2) -> bool:
        """Whether there is a way from a pose to another."""
        return not self._base.make_plan(start, goal).reason

    def fitted(self, guess: Pose2, scan: Scan) -> Pose2:
        """The pose near a guess from which a scan fits the map best."""
        return fitted(guess, scan, self.ways.grid)


def run_physics_round(layout: Layout, controller: str, seed: int, switches: Switches = NOTHING) -> RoundRecord:
    """One round in a layout in full physics, from an unknown place (ours) or one that is given by hand.

    Args:
        layout: boxes and tags.
        controller: one of CONTROLLERS.
        seed: of noise and light.
        switches: known faults of the report's program; only for its round, and only some of FAULTS_IN_PHYSICS.

    Raises:
        ValueError: no such controller, or a fault that it does not have here.
        SlamError: the localisation's library is not built.
    """
    if switches not in ((NOTHING,) if controller != REPORT else FAULTS_IN_PHYSICS.values()):
        raise ValueError(f"controller {controller!r} in physics does not have these faults: {switches}")
    if controller not in CONTROLLERS:
        raise ValueError(f"controller {controller!r} is not known; known: {', '.join(CONTROLLERS)}")
    with PhysicsWorld(layout.arena, seed, low_obstacles) as world:
        return _run(world, layout, controller, seed, switches)


def _run(world: RoomRobot, layout: Layout, controller: str, seed: int, switches: Switches) -> RoundRecord:
    robot, recorder = _Robot(world, layout, controller, seed, switches), RoundRecorder()
    params = SessionParams(LIMIT_S, RoundParams().turn_rate, autostart=True)
    session = InspectionSession(params, lambda: _made(robot, layout, controller, switches), robot.fitted)
    looking, passes, computing_s = False, 0, 0.0
    last: Optional[SessionStep] = None
    while passes * LOOP_S < LIMIT_S + AFTER_S:
        seen = robot.observe(round(passes * LOOP_S, 6), looking)
        began = time.process_time()
        last = session.step(seen)
        computing_s += time.process_time() - began
        _note(recorder, world, seen, last, controller)
        if last.step is not None and last.step.stage in ENDS:
            break
        looking = last.step is not None and isinstance(last.step.order, Look)
        robot.act(seen, last)
        passes += 1
    assert last is not None
    for touch in world.touches:
        recorder.touched(TouchRow(touch.t_s, touch.block, touch.x, touch.y))
    ended = last.step.stage if last.step is not None else Stage.FAILED
    return recorder.finish(
        RoundInfo(layout.arena.name, controller, seed, "physics", LIMIT_S, DETECTOR),
        (last.elapsed_s, ended, last.reason),
        tuple(boxes_of(layout)),
        dict(enumerate(layout.tags, start=1)),
        session.verdicts,
        computing_s,
    )


def _made(robot: _Robot, layout: Layout, controller: str, switches: Switches) -> Tuple[RoundFlow, Reader]:
    """The round of a controller, and who reads for it."""
    boxes = boxes_of(layout)
    reader = make_reader(controller, boxes, shipped_pictures())
    if controller == OURS:
        return Round(boxes, robot.ways.lengths, chances(boxes, LookChance()), gap=robot.ways.gap), reader
    if controller == PRINTED:
        return PrintedRound(boxes, robot.plannable), reader
    return SwitchedRound(boxes, robot.plannable, robot.ways.gap, switches), reader


def _note(recorder: RoundRecorder, world: RoomRobot, seen: Senses, made: SessionStep, controller: str) -> None:
    """One pass of the round."""
    if made.step is None or made.observation is None:
        return
    observation, read = made.observation, made.action.read
    recorder.stepped(made.elapsed_s, replace(made.step, events=made.events), observation.outcome, observation.reason)
    recorder.passed(made.elapsed_s, world.truth, seen.pose)
    if read is not None:
        recorder.looked(LookRecord.of(made.elapsed_s, read, controller == PRINTED))
