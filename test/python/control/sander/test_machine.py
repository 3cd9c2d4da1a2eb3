"""The sander's state machine with an arm that follows exactly."""

from __future__ import annotations

from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np
import pytest

from python.control.arm_samples import PART_LOWER, PART_TOP_M, PART_UPPER, TOOL_RADIUS_M, arm, planner, scan
from yarm.control.arm.collision import ArmCollision
from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import tool_pose
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.machine import ArmInputs, SanderMachine
from yarm.control.sander.params import SanderParams
from yarm.control.sander.progress import KeepOff
from yarm.control.sander.raster import coverage
from yarm.control.sander.states import Button, SanderState
from yarm.control.sander.steps import DoneJob
from yarm.robots.hc10 import Box

TICK_S = 1.0 / 60.0
ROBOT_ARM_TOP_M = 0.93


class Cell:
    """Machine and arm, tick by tick."""

    def __init__(
        self, run_job=DoneJob, points: Optional[np.ndarray] = None, blocked: bool = False, spacing_m: float = 0.04
    ) -> None:
        found = scan() if points is None else points
        self.machine = SanderMachine(planner(spacing_m), SanderParams(), run_job, lambda: found)
        self.q = arm().storage.copy()
        self.now_s = 0.0
        self.blocked = blocked
        self.motion: Optional[ArmMotion] = None
        self.motion_s = 0.0
        self.objection = ""
        self.keep_off: Optional[KeepOff] = None
        self.log: List[Tuple[float, np.ndarray, SanderState]] = [(0.0, self.q, self.machine.state)]

    def run(
        self,
        limit_s: float,
        presses: Sequence[Button] = (),
        switches: Sequence[bool] = (),
        axes: Optional[Tuple[float, float, float, float]] = None,
        until: Callable[[], bool] = lambda: False,
    ) -> bool:
        """Go on for a time or until something is true; whether it became true."""
        end = self.now_s + limit_s
        while self.now_s < end - 1e-9:
            self.now_s += TICK_S
            inputs = ArmInputs(self.q, self.now_s, presses, axes, switches, self.objection, self.keep_off)
            self.keep_off = None
            for motion in self.machine.step(inputs):
                self.motion, self.motion_s = motion, self.now_s
            presses, switches = (), ()
            if self.motion is not None and not self.blocked:
                self.q = self.motion.at(self.now_s + TICK_S - self.motion_s)
            self.log.append((self.now_s, self.q.copy(), self.machine.state))
            if until():
                return True
        return False

    def to(self, state: SanderState, *presses: Button) -> None:
        """Press and wait until a state is entered and nothing moves."""
        machine = self.machine
        assert self.run(60.0, presses, until=lambda: machine.state is state and not machine.report.moving), (
            machine.report
        )

    def tip(self) -> np.ndarray:
        return planner().kinematics.tip(self.q)[:3, 3]

    def teleoperation(self) -> None:
        self.to(SanderState.TELEOPERATION, Button.ADVANCE)

    def sanding(self, progress: float) -> None:
        self.teleoperation()
        assert self.run(90.0, [Button.START], until=lambda: self.machine.report.progress >= progress)


@pytest.fixture(scope="module")
def whole() -> Cell:
    """A whole run: storage, scan, part, raster with a pause, a turn in mid-lift, storage."""
    cell = Cell()
    cell.sanding(0.1)
    cell.run(4.0, switches=[False])
    cell.run(4.0, switches=[True])
    cell.run(0.6, switches=[False])
    assert cell.run(
        90.0, switches=[True], until=lambda: cell.machine.report.progress >= 1.0 and not cell.machine.report.moving
    )
    cell.to(SanderState.STORAGE, Button.STORE)
    return cell


def test_states_come_in_order(whole):
    states = [entry[2] for entry in whole.log]
    order = [int(s) for i, s in enumerate(states) if i == 0 or states[i - 1] is not s]
    assert order == [0, 1, 2, 3, 4, 5, 0]


def test_limits_and_speeds_are_never_exceeded(whole):
    q = np.array([entry[1] for entry in whole.log])
    assert arm().limits.contain(q)
    speeds = np.abs(np.diff(q, axis=0)) / TICK_S
    assert np.all(speeds <= arm().limits.speed)


def test_nothing_is_touched(whole):
    for _, q, state in whole.log[::20]:
        assert planner().collision.free(q, 0.005, sanding=state is SanderState.SCAN_TO_PATH)


def test_the_whole_part_is_covered_with_the_tool_upright(whole):
    poses = [planner().kinematics.tip(q) for _, q, state in whole.log if state is SanderState.SCAN_TO_PATH]
    tips = np.array([pose[:3, 3] for pose in poses])
    assert coverage(tips, PART_LOWER, PART_UPPER, PART_TOP_M, TOOL_RADIUS_M) >= 0.95
    low = tips[:, 2] < PART_TOP_M + 0.004
    tilts = np.degrees(np.arccos([min(-pose[2, 2], 1.0) for pose in poses]))
    assert tilts[low].max() < 5.0


def test_sanding_goes_at_the_set_speed(whole):
    tips = np.array([planner().kinematics.tip(q)[:3, 3] for _, q, _ in whole.log])
    low = tips[:, 2] < PART_TOP_M + 0.003
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1)[low[1:] & low[:-1]] / TICK_S
    assert np.median(speeds) == pytest.approx(0.1, abs=0.002)
    assert speeds.max() < 0.13


def test_pausing_stops_within_0_3_s_lifts_and_resumes_at_the_same_place():
    cell = Cell()
    cell.sanding(0.2)
    before = cell.tip()
    cell.run(0.3, switches=[False])
    assert np.linalg.norm(cell.tip()[:2] - before[:2]) < 0.02
    stopped = cell.tip()
    assert cell.run(5.0, until=lambda: cell.machine.report.lifted)
    assert cell.tip()[2] >= 1.15
    assert np.linalg.norm(cell.tip()[:2] - stopped[:2]) < 0.005
    progress = cell.machine.report.progress
    cell.run(0.1, switches=[True])
    assert cell.run(5.0, until=lambda: cell.tip()[2] < PART_TOP_M + 0.003)
    assert np.linalg.norm(cell.tip()[:2] - stopped[:2]) < 0.01
    assert cell.machine.report.progress == pytest.approx(progress, abs=0.005)


def test_paused_before_the_start_it_hovers_and_sands_nothing():
    cell = Cell()
    cell.teleoperation()
    cell.run(5.0, [Button.START], [False])
    assert cell.machine.report.lifted and cell.machine.report.progress == 0.0
    assert cell.tip()[2] >= 1.15


def test_the_hover_is_above_the_robots_arms():
    cell = Cell()
    cell.teleoperation()
    for x in (-0.43, -0.25, -0.07):
        for y in (-0.28, 0.0, 0.28):
            q = planner().kinematics.solve(_over(x, y), np.array(SanderParams().ready_pose))
            assert lowest_beyond_the_stand(q) > ROBOT_ARM_TOP_M + 0.05, (x, y)


def _over(x: float, y: float) -> np.ndarray:
    return tool_pose(np.array([x, y, SanderParams().hover_height_m]), np.array([0.0, 0.0, 1.0]), 0.0)


def lowest_beyond_the_stand(q: np.ndarray) -> float:
    """Least height of the arm over the table, by the distance to a table as high as the robots' arms."""
    table = Box("arms", (1.4, 2.0, ROBOT_ARM_TOP_M), (-0.1, 0.0, ROBOT_ARM_TOP_M / 2))
    model = ArmCollision(arm(), (table,))
    clearance = model.clearance(q, 0.5)
    model.close()
    return ROBOT_ARM_TOP_M + (clearance.distance_m if "arms" in clearance.between else 0.5)


@pytest.mark.parametrize(
    ("state", "button"),
    [(0, Button.START), (0, Button.STORE), (3, Button.ADVANCE), (4, Button.ADVANCE)],
)
def test_a_button_without_meaning_is_answered_with_a_reason(state, button):
    cell = Cell()
    if state >= 3:
        cell.teleoperation()
    if state == SanderState.SCAN_TO_PATH:
        cell.run(1.0, [Button.START], [False])
    cell.run(0.2, [button])
    assert cell.machine.state is SanderState(state)
    assert f"button {button.name.lower()} does nothing in state {state}" in cell.machine.report.reason


@pytest.mark.parametrize("after_s", [0.5, 3.0, 4.9])
def test_hold_stops_and_advance_goes_on(after_s):
    cell = Cell()
    cell.run(after_s, [Button.ADVANCE])
    cell.run(0.4, [Button.HOLD])
    held = cell.q.copy()
    cell.run(1.0)
    assert cell.q == pytest.approx(held)
    assert "held" in cell.machine.report.reason
    cell.to(SanderState.TELEOPERATION, Button.ADVANCE)


def test_store_while_sanding_lifts_first():
    cell = Cell()
    cell.sanding(0.1)
    cell.to(SanderState.STORAGE, Button.STORE)
    assert cell.q == pytest.approx(arm().storage, abs=1e-3)
    for _, q, _ in cell.log[::5]:
        assert planner().collision.free(q, 0.005, sanding=True)


def test_start_again_after_the_raster_sands_again():
    cell = Cell(spacing_m=0.2)
    cell.sanding(0.05)
    assert cell.run(60.0, until=lambda: cell.machine.report.progress >= 1.0 and not cell.machine.report.moving)
    cell.run(1.0, [Button.START])
    assert cell.machine.report.progress < 0.2
    assert cell.machine.state is SanderState.SCAN_TO_PATH


def test_a_scan_without_a_part_keeps_it_where_it_is_and_says_why():
    cell = Cell(points=np.zeros((0, 3)))
    cell.teleoperation()
    before = cell.q.copy()
    cell.run(2.0, [Button.START])
    assert "stays where it is: the scan holds no points" in cell.machine.report.reason
    assert cell.q == pytest.approx(before, abs=0.02)


def test_an_arm_that_does_not_follow_is_noticed():
    cell = Cell(blocked=True)
    cell.run(10.0, [Button.ADVANCE])
    assert "does not follow: joint" in cell.machine.report.reason


def test_blocked_while_sanding_it_goes_on_when_switched_on_again():
    cell = Cell()
    cell.sanding(0.1)
    cell.blocked = True
    assert cell.run(20.0, until=lambda: bool(cell.machine.report.reason))
    assert "does not follow" in cell.machine.report.reason
    stopped = cell.machine.report.progress
    cell.blocked = False
    cell.run(10.0, switches=[False])
    assert cell.machine.report.progress == stopped
    assert cell.run(20.0, switches=[True], until=lambda: cell.machine.report.progress > stopped + 0.02)
    assert cell.machine.report.reason == ""


def test_switching_on_does_not_undo_a_hold():
    cell = Cell()
    cell.sanding(0.1)
    cell.run(1.0, [Button.HOLD])
    held = cell.q.copy()
    cell.run(2.0, switches=[False, True])
    assert cell.q == pytest.approx(held)


def test_teleoperation_moves_the_tip_along_the_axes_and_stops():
    cell = Cell()
    cell.teleoperation()
    before = cell.tip()
    cell.run(1.0, axes=(0.0, 1.0, -1.0, 0.0))
    moved = cell.tip() - before
    assert moved == pytest.approx([0.0, 0.1, -0.1], abs=0.015)
    cell.run(1.0, axes=(0.0, 0.0, 0.0, 0.0))
    rest = cell.tip()
    cell.run(1.0)
    assert cell.tip() == pytest.approx(rest, abs=1e-6)


def test_teleoperation_stops_before_the_part_and_says_so():
    cell = Cell()
    cell.teleoperation()
    cell.run(8.0, axes=(0.0, 0.0, -1.0, 0.0))
    assert PART_TOP_M + 0.01 < cell.tip()[2] < PART_TOP_M + 0.06
    assert "sander and part" in cell.machine.report.reason


def test_teleoperation_without_news_stops():
    cell = Cell()
    cell.teleoperation()
    cell.run(0.5, axes=(0.0, 1.0, 0.0, 0.0))
    cell.run(1.0)
    rest = cell.tip()
    cell.run(1.0)
    assert cell.tip() == pytest.approx(rest, abs=1e-6)


def test_a_slow_computation_leaves_the_arm_at_rest_until_it_is_done():
    waiting: List[Callable[[], object]] = []

    class Slow:
        def __init__(self, function: Callable[[], object]) -> None:
            self.function = function
            waiting.append(function)

        def done(self) -> bool:
            return not waiting

        def result(self) -> object:
            return self.function()

    cell = Cell(run_job=Slow)
    cell.run(1.0, [Button.ADVANCE])
    assert cell.machine.report.moving and cell.motion is None
    waiting.clear()
    cell.run(0.5)
    assert cell.motion is not None


def test_a_failing_computation_is_a_reason_not_a_crash():
    def fail() -> None:
        raise ArmError("no way")

    job = DoneJob(fail)
    with pytest.raises(ArmError, match="no way"):
        job.result()


def test_reset_is_back_in_storage():
    cell = Cell()
    cell.sanding(0.05)
    cell.machine.reset()
    assert cell.machine.state is SanderState.STORAGE
    assert cell.machine.report.presses == 0


def stands(cell: Cell, seconds: float) -> bool:
    """Whether the arm is at rest during some seconds."""
    before = cell.q.copy()
    cell.run(seconds)
    return bool(np.allclose(cell.q, before))


def test_an_objection_stops_the_raster_at_once_and_without_it_the_raster_goes_on_where_it_stopped():
    cell = Cell()
    cell.sanding(0.2)
    stopped = cell.tip()
    cell.objection = "stands: nothing heard from commander yet"
    cell.run(0.3)
    assert np.linalg.norm(cell.tip() - stopped) < 0.02
    assert stands(cell, 3.0)
    assert cell.tip()[2] < PART_TOP_M + 0.003
    assert cell.machine.report.reason == "stands: nothing heard from commander yet"
    assert not cell.machine.report.moving
    progress = cell.machine.report.progress
    cell.objection = ""
    cell.run(0.1)
    assert cell.run(90.0, until=lambda: cell.machine.report.progress > progress + 0.01)
    assert cell.machine.report.progress < progress + 0.02
    assert cell.machine.report.reason == ""


def test_an_objection_keeps_a_paused_arm_paused_whatever_is_switched_on():
    cell = Cell()
    cell.sanding(0.1)
    cell.run(4.0, switches=[False])
    cell.objection = "stands"
    cell.run(0.1, switches=[True])
    assert stands(cell, 2.0)
    cell.objection = ""
    assert cell.run(5.0, until=lambda: cell.tip()[2] < PART_TOP_M + 0.003)


@pytest.mark.parametrize(
    ("state", "end"),
    [
        (SanderState.SCANNING, SanderState.TELEOPERATION),
        (SanderState.MOVE_TO_PART, SanderState.TELEOPERATION),
        (SanderState.SCAN_TO_PATH, SanderState.SCAN_TO_PATH),
        (SanderState.MOVE_TO_STORAGE, SanderState.STORAGE),
    ],
)
def test_an_objection_in_any_state_stops_the_arm_twice_and_it_still_gets_there(state, end):
    cell = Cell(spacing_m=0.2)
    machine = cell.machine
    if state in (SanderState.SCANNING, SanderState.MOVE_TO_PART):
        presses = [Button.ADVANCE]
    else:
        cell.teleoperation()
        presses = [Button.START if state is SanderState.SCAN_TO_PATH else Button.STORE]
    assert cell.run(60.0, presses, until=lambda: machine.state is state and machine.report.moving)
    for _ in range(2):
        cell.run(0.5)
        cell.objection = "stands"
        cell.run(0.3)
        assert stands(cell, 1.0)
        cell.objection = ""
    assert cell.run(120.0, until=lambda: machine.state is end and not machine.report.moving), machine.report


def test_an_objection_while_the_tool_is_lifted_for_storage_does_not_forget_the_storage():
    cell = Cell()
    cell.sanding(0.05)
    cell.run(0.4, [Button.STORE])
    assert cell.machine.state is SanderState.SCAN_TO_PATH
    for _ in range(2):
        cell.objection = "stands"
        cell.run(0.5)
        cell.objection = ""
        cell.run(0.1)
    assert cell.run(60.0, until=lambda: cell.machine.state is SanderState.STORAGE)


def test_an_objection_stops_teleoperation_and_the_axes_must_be_pushed_again():
    cell = Cell()
    cell.teleoperation()
    cell.run(0.5, axes=(0.0, 0.0, -1.0, 0.0))
    cell.objection = "stands"
    cell.run(0.05, axes=(0.0, 0.0, -1.0, 0.0))
    assert stands(cell, 0.5)
    cell.objection = ""
    assert stands(cell, 0.3)
