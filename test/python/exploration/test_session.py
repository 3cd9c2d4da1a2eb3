"""One run from the start to the saved map: states, requests, sick sensors, the deadline, the way back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from yarm.exploration.deadline import SETTLE_S, Gate
from yarm.exploration.map_keeper import EVERY_S
from yarm.exploration.model import LOOP_S, Command, LowView, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.session import ALLOWED, Request, Session, State
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.navigation.path_check import PathVerdict
from yarm.robots.turtlebot import Bumper, BumperEvent

AHEAD = Command(0.2, 0.1)


def room(side_m=8.0, free=True):
    """An empty square room around the origin with walls."""
    n = int(side_m / 0.05)
    cells = np.zeros((n, n), np.int8) if free else np.full((n, n), -1, np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = 100
    return GridMap(cells, 0.05, Pose2(-side_m / 2, -side_m / 2))


class Scripted:
    """A controller that gives what it is told and remembers what it saw."""

    def __init__(self):
        self.seen = []
        self.answer = Step(AHEAD, "forward")

    def step(self, observation):
        self.seen.append(observation)
        return self.answer


class Run:
    """A session and a robot that does what it is told."""

    def __init__(self, autostart=True, began_s=50.0, **params):
        self.made = []
        self.session = Session(ExploreParams(**params), self.make, autostart)
        self.rng = np.random.default_rng(1)
        self.pose, self.now_s, self.began_s = Pose2(0.0, 0.0), began_s, began_s
        self.map, self.count, self.T_map_odom = room(), 1, Pose2(0.0, 0.0)
        self.bumps = ()
        self.events, self.saves, self.steps = [], [], []

    def make(self):
        self.made.append(Scripted())
        return self.made[-1]

    @property
    def controller(self):
        return self.made[-1]

    def seen(self):
        scan = Scan(self.now_s, self.rng.normal(2.0, 0.01, 64).astype(np.float32), -0.5, 1 / 63, 0.45, 10.0)
        return Observation(
            self.now_s, Odometry(self.now_s, self.pose), self.T_map_odom, scan, self.bumps, self.map, self.count
        )

    def go(self, seconds=LOOP_S, **changes):
        for _ in range(round(seconds / LOOP_S)):
            self.now_s = round(self.now_s + LOOP_S, 6)
            last = self.session.step(replace(self.seen(), **changes))
            self.bumps = ()
            self.steps.append(last)
            self.events += last.events
            self.saves += last.saves
            turn = Pose2(last.command.v_mps * LOOP_S, 0.0, last.command.w_radps * LOOP_S)
            self.pose = self.pose.compose(turn)
        return last

    def kinds(self, kind):
        return [dict(event.details) for event in self.events if event.kind == kind]


def test_it_starts_by_itself_when_every_sensor_is_there():
    run = Run()
    waiting = run.go(2.0, map=None)
    assert waiting.state is State.IDLE and "waits to start: pose: there is no map yet" in waiting.reason
    assert waiting.command == Command()
    assert not run.made
    started = run.go()
    assert started.state is State.EXPLORING
    assert started.command == Command(), "the gate hears first that the robot may move"
    assert started.elapsed_s == pytest.approx(0.0)
    assert run.go().command == AHEAD


def test_without_autostart_it_waits_for_the_request():
    run = Run(autostart=False)
    assert run.go(1.0).state is State.IDLE
    assert run.session.ask(Request.START).success
    assert run.go().state is State.EXPLORING


def test_the_controller_counts_from_the_start_of_the_run():
    run = Run(began_s=1234.0)
    run.go(3.0)
    seen = run.controller.seen
    assert seen[0].now_s == pytest.approx(0.0)
    assert seen[-1].now_s == pytest.approx(2.9)
    assert seen[-1].scan.stamp_s == pytest.approx(seen[-1].now_s)
    assert seen[-1].odometry.stamp_s == pytest.approx(seen[-1].now_s)


@pytest.mark.parametrize("request_", list(Request))
@pytest.mark.parametrize("state", list(State))
def test_a_request_in_a_state_that_does_not_allow_it_is_refused_with_those_that_do(request_, state):
    run = Run()
    run.go(1.0)
    reach = {
        State.IDLE: run.session.restart,
        State.EXPLORING: lambda: None,
        State.PAUSED: lambda: run.session.ask(Request.PAUSE),
        State.RETURNING: lambda: run.session.ask(Request.RETURN_TO_START),
        State.DONE: lambda: run.session.ask(Request.STOP),
        State.FAILED: lambda: setattr(run, "pose", Pose2(50.0, 0.0)),
    }
    reach[state]()
    if state is State.RETURNING:
        run.pose = Pose2(1.0, 0.0)
    if state is not State.IDLE:
        assert run.go(1.0 if state is not State.FAILED else 3.0).state is state
    answer = run.session.ask(request_)
    allowed = state in ALLOWED[request_] and not (state is State.IDLE and request_ is Request.SAVE_MAP)
    assert answer.success == allowed, answer.message
    if state not in ALLOWED[request_]:
        assert f"it is {state.value}" in answer.message


def test_pause_stands_and_resume_goes_on_while_the_time_runs():
    run = Run()
    run.go(1.0)
    run.session.ask(Request.PAUSE)
    paused = run.go(10.0)
    assert paused.state is State.PAUSED
    assert paused.command == Command()
    asked = len(run.controller.seen)
    run.session.ask(Request.RESUME)
    on = run.go(2 * LOOP_S)
    assert on.command == AHEAD
    assert len(run.controller.seen) == asked + 2
    assert on.elapsed_s == pytest.approx(11.1)


def test_stop_ends_and_saves_and_another_run_may_follow():
    run = Run()
    run.go(5.0)
    run.session.ask(Request.STOP)
    stopped = run.go()
    assert (stopped.state, stopped.reason) == (State.DONE, "stopped on request")
    assert [order.why for order in run.saves] == ["stop"]
    assert run.go(3.0).elapsed_s == pytest.approx(5.0)
    assert run.session.ask(Request.START).success
    again = run.go()
    assert again.state is State.EXPLORING
    assert again.elapsed_s == pytest.approx(0.0)
    assert len(run.made) == 2


def test_it_stands_before_the_deadline_and_cannot_be_started_again():
    run = Run(time_limit_s=20.0)
    run.go(19.5 + LOOP_S)
    standing = run.steps[-2:]
    assert all(step.command == Command() for step in standing)
    assert run.go(5.0).reason == "the time is over"
    assert run.steps[-1].state is State.DONE
    assert run.steps[-1].left_s <= SETTLE_S
    assert not run.session.ask(Request.START).success
    assert run.saves[-1].why == "end"


def test_the_gate_changes_nothing_while_the_session_is_well():
    """Pass by pass: what the session says is what the gate lets through, from the first second to past the last."""
    run, gate = Run(time_limit_s=10.0), Gate()
    for _ in range(120):
        step = run.go()
        gate.hear(run.session.lease(), run.now_s)
        gate.want(step.command, run.now_s)
        assert gate.step(run.now_s).command == step.command
    assert run.steps[-1].state is State.DONE


@pytest.mark.parametrize("autostart", [True, False])
def test_the_gate_opens_for_a_run_that_begins_long_after_the_last_deadline_or_the_first_word(autostart):
    run, gate = Run(autostart=autostart, time_limit_s=10.0), Gate()
    for second in range(40):
        if second == 5 and autostart:
            run.session.ask(Request.STOP)
        if second == 35:
            assert run.session.ask(Request.START).success
        step = run.go(1.0)
        gate.hear(run.session.lease(), run.now_s)
        gate.want(step.command, run.now_s)
        passed = gate.step(run.now_s)
    assert step.state is State.EXPLORING
    assert passed.command == step.command == AHEAD


def test_a_controller_that_has_nothing_left_ends_the_run():
    run = Run()
    run.go(3.0)
    run.controller.answer = Step(done=True, reason="nothing is left: 2 frontiers too narrow for the disc")
    done = run.go()
    assert done.state is State.DONE
    assert "too narrow" in done.reason
    assert done.command == Command()
    assert run.saves[-1].why == "end"


def test_nothing_left_before_it_has_moved_means_enclosed():
    run = Run()
    run.go(2 * LOOP_S)
    run.controller.answer = Step(done=True, reason="nothing can be reached")
    failed = run.go()
    assert failed.state is State.FAILED
    assert failed.reason == "enclosed at the start: nothing can be reached"


def test_a_robot_outside_its_map_ends_with_both_places_named():
    run = Run()
    run.go(1.0)
    run.pose = Pose2(20.0, 0.0)
    run.go(3.0)
    assert run.steps[-1].state is State.FAILED
    assert "the robot at (20." in run.steps[-1].reason
    assert "outside its map, (-3.98, -3.98) to (3.98, 3.98)" in run.steps[-1].reason


def straight_on(run):
    run.go(1.0)
    run.controller.answer = Step(Command(0.3, 0.0), "forward")


def test_a_robot_that_drives_off_its_map_waits_for_the_next_one():
    """Maps come every 5 s, and the first may show less than is driven until the second."""
    run = Run()
    run.map = room(1.0)
    straight_on(run)
    for _ in range(4):
        run.go(5.0)
        assert run.steps[-1].state is State.EXPLORING, run.steps[-1].reason
        run.map, run.count = room(2.0 * run.pose.x + 0.4), run.count + 1
    assert run.pose.x > 5.0


def test_a_new_map_that_does_not_show_the_robot_ends_the_run():
    run = Run()
    run.map = room(1.0)
    straight_on(run)
    run.go(5.0)
    assert run.steps[-1].state is State.EXPLORING
    run.count += 1
    run.go(3.0)
    assert run.steps[-1].state is State.FAILED
    assert "is outside its map" in run.steps[-1].reason


@pytest.mark.parametrize("lost", ["scan", "odometry"])
def test_a_lost_sensor_stops_it_within_half_a_second_saves_and_goes_on(lost):
    run = Run()
    run.go(2.0)
    last, last_s = getattr(run.seen(), lost), run.now_s
    while run.steps[-1].command != Command():
        run.go(**{lost: last})
    assert run.now_s - last_s <= 0.5
    held = run.go(5.0, **{lost: last})
    assert held.state is State.EXPLORING
    assert held.behaviour == "hold"
    assert held.reason.startswith(f"{lost}: none newer than")
    assert [order.why for order in run.saves] == [f"{lost} lost"]
    asked = len(run.controller.seen)
    on = run.go()
    assert on.command == AHEAD
    assert on.reason == ""
    assert len(run.controller.seen) == asked + 1
    assert [entry["what"] for entry in run.kinds("sensor")][-1] == "is back"


def test_a_mapping_that_dies_and_comes_back_elsewhere():
    run = Run()
    run.map = room()
    run.go(5.0)
    good, start = run.map, run.session._start
    held = run.go(3.0, map_from_odom=None)
    assert held.command == Command()
    assert "no transform map -> odom" in held.reason
    run.map = GridMap(np.where(np.indices(good.cells.shape)[0] < 30, good.cells, -1), 0.05, good.origin)
    run.count += 1
    run.T_map_odom = Pose2(0.5, -0.3, 0.4)
    assert run.go().behaviour == "hold"
    run.go(1.0)
    kept = [order for order in run.saves if order.last_good]
    assert [order.map for order in kept] == [good]
    assert run.steps[-1].command == AHEAD
    jumps = [seen.jumped for seen in run.controller.seen]
    assert jumps.count(True) == 1
    assert run.session._start == run.T_map_odom.compose(start)


def test_values_between_free_and_occupied_count_as_unknown():
    run = Run()
    run.go()
    cells = np.full((100, 100), 50, np.int8)
    cells[:20], cells[20:40] = 25, 65
    run.map, run.count = GridMap(cells, 0.05, Pose2(-1.0, -1.0)), 2
    assert run.go().known_m2 == pytest.approx(40 * 100 * 0.05**2)


def test_a_map_that_grows_and_moves_its_origin_is_taken_as_it_comes():
    run = Run()
    run.go(1.0)
    run.map, run.count = room(12.0), 2
    assert run.go(1.0).known_m2 == pytest.approx(144.0)
    assert run.controller.seen[-1].map is run.map


def test_time_going_backwards_starts_afresh():
    run = Run()
    run.go(10.0)
    run.session.restart()
    run.now_s = 0.0
    again = run.go()
    assert again.state is State.EXPLORING
    assert again.elapsed_s == pytest.approx(0.0)
    assert len(run.made) == 2


def test_the_map_is_saved_every_thirty_seconds():
    run = Run()
    for _ in range(100):
        run.pose = Pose2(0.0, 0.0)
        run.count += 1
        run.go(1.0)
    assert [order.why for order in run.saves] == [f"every {EVERY_S:.0f} s"] * 3


def test_a_node_that_ends_saves_the_map_of_a_run_that_has_not():
    run = Run()
    run.go(1.0)
    order = run.session.last_order(1.0)
    assert order is not None and (order.why, order.map) == ("the node ends", run.session.keeper.newest)
    run.session.ask(Request.STOP)
    run.go(3.0)
    assert [order.why for order in run.saves] == ["stop"]
    assert run.session.last_order(4.0) is None


def test_save_map_is_done_at_the_next_pass():
    run = Run()
    run.go(1.0)
    assert run.session.ask(Request.SAVE_MAP).success
    run.go()
    assert [order.why for order in run.saves] == ["asked for"]
    assert run.steps[-1].state is State.EXPLORING


def test_bumps_are_counted_with_place_and_speed():
    run = Run()
    run.go(2.0)
    run.bumps = (BumperEvent(Bumper.LEFT, True), BumperEvent(Bumper.LEFT, False))
    assert run.go().bumps == 1
    (bump,) = run.kinds("bump")
    assert bump["sector"] == "LEFT"
    assert bump["v"] == pytest.approx(AHEAD.v_mps)
    assert math.hypot(bump["x"] - run.pose.x, bump["y"] - run.pose.y) < 0.05


def test_no_controller_drives_faster_than_max_speed():
    run = Run(max_speed=0.25)
    run.go()
    run.controller.answer = Step(Command(0.6, 2.0), "fast")
    assert run.go().command == Command(0.25, 2.0)


def test_what_was_bumped_into_and_what_is_low_is_in_the_map_that_is_saved():
    run = Run()
    run.go(2.0)
    run.go(low=LowView(run.now_s + LOOP_S, np.array([[1.0, 0.3]])))
    run.bumps = (BumperEvent(Bumper.CENTER, True),)
    run.go()
    marked = run.controller.seen[-1].map
    touched = run.controller.seen[-1].pose.compose(Pose2(0.2, 0.0))
    row, column = marked.cell_of(touched.x, touched.y)
    assert marked.occupied[row - 1 : row + 2, column - 1 : column + 2].any()
    run.session.ask(Request.SAVE_MAP)
    run.go()
    assert np.count_nonzero(run.saves[-1].map.occupied) > np.count_nonzero(run.map.occupied) + 3


def drive_off(run, x=2.5):
    """Straight ahead to x, then standing."""
    run.go()
    run.controller.answer = Step(Command(0.2, 0.0), "forward")
    while run.pose.x < x:
        run.go()
    run.controller.answer = Step(Command(), "stand")


def wall_off(run, columns):
    cells = run.map.cells.copy()
    cells[:, columns] = 100
    run.map, run.count = replace(run.map, cells=cells), 2


def ends_at_the_start(run):
    while run.steps[-1].state in (State.EXPLORING, State.RETURNING) and run.now_s < 250.0:
        run.go()
    last = run.steps[-1]
    return last.state is State.DONE and "back at the start" in last.reason and run.pose.distance(Pose2(0.0, 0.0)) < 0.15


def test_asked_to_return_it_comes_back_and_ends():
    run = Run()
    drive_off(run)
    assert run.session.ask(Request.RETURN_TO_START).success
    assert ends_at_the_start(run)


def test_the_reserve_for_the_way_back_is_enough():
    run = Run(time_limit_s=120.0, return_to_start=True)
    drive_off(run, 3.0)
    run.go(110.0)
    (leaving,) = [event for event in run.events if dict(event.details).get("to") == "returning"]
    assert 60.0 < leaving.t_s < 100.0
    assert ends_at_the_start(run)


def test_done_early_with_return_to_start_it_comes_back():
    run = Run(return_to_start=True)
    drive_off(run, 1.0)
    run.controller.answer = Step(done=True, reason="nothing is left")
    run.go(60.0)
    assert (run.steps[-1].state, run.steps[-1].reason) == (State.DONE, "back at the start; nothing is left")


def test_a_bump_on_the_way_back_is_backed_off_from_and_driven_round():
    run = Run()
    drive_off(run)
    run.session.ask(Request.RETURN_TO_START)
    while run.pose.x > 1.5:
        run.go()
    run.bumps = (BumperEvent(Bumper.CENTER, True),)
    backing = run.go()
    assert backing.state is State.RETURNING and backing.command.v_mps < 0.0
    run.bumps = (BumperEvent(Bumper.CENTER, False),)
    run.go(1.0)
    assert run.pose.x > 1.53
    assert ends_at_the_start(run)


def test_a_way_back_that_the_checker_refuses_is_not_driven(monkeypatch):
    run = Run()
    drive_off(run)
    monkeypatch.setattr("yarm.exploration.driver.check_path", lambda *_: PathVerdict(False, 0.0, 0, "made up"))
    run.session.ask(Request.RETURN_TO_START)
    ended = run.go(1.0)
    assert ended.state is State.DONE and "the way was refused: made up" in ended.reason
    assert all(step.command == Command() for step in run.steps[-9:])


def test_a_start_that_the_disc_does_not_fit_is_come_back_to_as_near_as_it_does():
    run = Run()
    drive_off(run)
    wall_off(run, slice(77, 78))
    run.session.ask(Request.RETURN_TO_START)
    run.go(60.0)
    assert run.steps[-1].state is State.DONE and "beside the start, as near as the disc gets" in run.steps[-1].reason
    assert 0.0 < run.pose.x < 0.3


def test_without_a_way_back_it_stays_and_says_so():
    run = Run()
    drive_off(run, 1.0)
    wall_off(run, slice(85, 88))
    run.session.ask(Request.RETURN_TO_START)
    ended = run.go(1.0)
    assert ended.state is State.DONE and "no way back to the start (0.00, 0.00)" in ended.reason


def test_a_lease_moves_nothing_outside_a_run():
    run = Run(autostart=False)
    run.go(1.0)
    assert not run.session.lease().moving
    run.session.ask(Request.START)
    run.go(1.0)
    lease = run.session.lease()
    assert lease.moving and lease.deadline_s - lease.started_s == pytest.approx(900.0)
    assert lease.stamp_s == pytest.approx(run.now_s)
