"""Orders carried out pass by pass: goals, turns, looks; held, failed and begun again as the senses tell."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Optional

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry
from yarm.inspection.executor import LOST_S, PICTURE_WAIT_S, SETTLE_S, Action, Executor
from yarm.inspection.model import ClearCostmaps, Drive, Look, Outcome, Reading, Spin, Stand
from yarm.inspection.readers import PictureRead, Shot
from yarm.inspection.senses import Picture, Senses
from yarm.tags.evidence import TagVerdict

GOAL = Drive(Pose2(2.0, 0.0), 10.0)
DARK = np.zeros((4, 4), np.uint8)


class CountingReader:
    """Is sure of tag 7 after so many pictures."""

    def __init__(self, needed: int) -> None:
        self.needed = needed
        self.poses: List[Pose2] = []
        self.without: List[int] = []

    def read(self, box: int, shot: Shot) -> PictureRead:
        self.poses.append(shot.robot)
        return PictureRead(box, shot, final=len(self.poses) >= self.needed)

    def missed(self, box: int, images: int) -> None:
        self.without.append(images)

    def reading(self, box: int) -> Reading:
        return Reading(7, 0.9999) if len(self.poses) >= self.needed else Reading()

    def evidence(self, box: int) -> Optional[TagVerdict]:
        return None


def senses(now_s: float, yaw_rad: float = 0.0, w_radps: float = 0.0, **changes: object) -> Senses:
    odometry = Odometry(now_s, Pose2(0.0, 0.0, yaw_rad), 0.0, w_radps)
    seen = Senses(now_s, None, odometry, Pose2(0.0, 0.0), now_s, True)
    return replace(seen, **changes)  # type: ignore[arg-type]


def executor(needed: int = 1) -> Executor:
    return Executor(CountingReader(needed))


def test_a_goal_is_given_once_and_its_end_is_the_orders() -> None:
    made = executor()
    made.take(GOAL, 5.0)
    assert made.step(senses(5.0)) == Action(goal=GOAL.goal)
    assert made.step(senses(5.1)) == Action()
    assert made.step(senses(7.0, goal=(Outcome.DONE, ""))).outcome == Outcome.DONE
    made.take(Drive(Pose2(1.0, 1.0), 10.0), 8.0)
    assert made.step(senses(8.0, goal=(Outcome.DONE, ""))).goal == Pose2(1.0, 1.0)
    failed = made.step(senses(9.0, goal=(Outcome.FAILED, "given up: no way")))
    assert (failed.outcome, failed.reason, failed.cancel) == (Outcome.FAILED, "given up: no way", False)


def test_a_goal_that_takes_too_long_is_taken_back() -> None:
    made = executor()
    made.take(GOAL, 0.0)
    made.step(senses(0.0))
    assert made.step(senses(10.0)).outcome == Outcome.BUSY
    late = made.step(senses(10.1))
    assert (late.outcome, late.cancel) == (Outcome.FAILED, True) and "not there after 10 s" in late.reason


def test_while_it_is_held_its_time_stands_still_and_then_the_goal_is_given_again() -> None:
    made = executor()
    made.take(GOAL, 0.0)
    made.step(senses(0.0))
    made.step(senses(1.0))
    held = made.step(senses(2.0), hold="scan: gone")
    assert (held.outcome, held.cancel, held.reason) == (Outcome.BUSY, True, "scan: gone")
    assert not made.step(senses(30.0), hold="scan: gone").cancel
    assert made.step(senses(30.1)).goal == GOAL.goal
    assert made.step(senses(38.0)).outcome == Outcome.BUSY
    assert made.step(senses(40.0)).outcome == Outcome.FAILED


def test_without_a_place_a_drive_stops_and_soon_fails_with_the_localisations_words() -> None:
    made = executor()
    made.take(GOAL, 0.0)
    made.step(senses(0.0))
    lost = made.step(senses(1.0, localised=False, place_fault="two places fit"))
    assert (lost.outcome, lost.cancel) == (Outcome.BUSY, True)
    failed = made.step(senses(1.0 + LOST_S, localised=False, place_fault="two places fit"))
    assert failed.outcome == Outcome.FAILED and "two places fit" in failed.reason


def test_a_place_found_again_in_time_goes_on_and_a_jump_gives_the_goal_again() -> None:
    made = executor()
    made.take(GOAL, 0.0)
    made.step(senses(0.0))
    made.step(senses(1.0, localised=False))
    assert made.step(senses(1.5)).goal == GOAL.goal
    assert made.step(senses(1.6)).goal is None
    assert made.step(senses(1.7), jump="the place has jumped").goal == GOAL.goal


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_turn_goes_by_odometry_and_settles(sign: float) -> None:
    made = executor()
    made.take(Spin(sign * 2.0 * math.pi, 0.5), 0.0)
    now_s, yaw = 0.0, 3.0
    while True:
        action = made.step(senses(now_s, yaw))
        if action.turn_radps == 0.0:
            break
        assert action.turn_radps == sign * 0.5
        now_s, yaw = now_s + 0.1, yaw + sign * 0.05
    assert now_s == pytest.approx(4.0 * math.pi, abs=0.2)
    assert made.step(senses(now_s + SETTLE_S - 0.1, yaw)) == Action()
    assert made.step(senses(now_s + SETTLE_S, yaw)).outcome == Outcome.DONE


def test_a_robot_that_does_not_turn_fails_and_without_odometry_it_waits_standing() -> None:
    made = executor()
    made.take(Spin(1.0, 0.5), 0.0)
    made.step(senses(0.0))
    assert made.step(senses(1.0), hold="odometry: gone").turn_radps == 0.0
    assert made.step(senses(100.0), hold="odometry: gone").outcome == Outcome.BUSY
    assert made.step(senses(110.0)).turn_radps == 0.5
    failed = made.step(senses(200.0))
    assert (failed.outcome, failed.turn_radps) == (Outcome.FAILED, 0.0)
    assert "does something hold the robot" in failed.reason


def look(made: Executor, order: Look, passes: Dict[float, Senses]) -> List[Action]:
    made.take(order, min(passes))
    return [made.step(seen) for _, seen in sorted(passes.items())]


def test_only_pictures_taken_standing_count_and_it_ends_when_it_is_sure() -> None:
    reader = CountingReader(2)
    made = Executor(reader)
    moving = {0.1 * i: senses(0.1 * i, w_radps=0.5, picture=Picture(0.1 * i, DARK)) for i in range(5)}
    standing = {0.1 * i: senses(0.1 * i, picture=Picture(0.1 * i - 0.05, DARK)) for i in range(5, 9)}
    actions = look(made, Look(3, 5, 2.0), {**moving, **standing})
    assert [action.read is not None for action in actions] == [False] * 7 + [True, True]
    assert actions[-1].outcome == Outcome.DONE and actions[-1].reading == Reading(7, 0.9999)


def test_it_ends_after_its_pictures_or_its_time() -> None:
    made = executor(99)
    passes = {0.1 * i: senses(0.1 * i, picture=Picture(0.1 * i, DARK)) for i in range(6)}
    actions = look(made, Look(3, 3, 2.0), passes)
    assert [a.outcome for a in actions[:5]] == [Outcome.BUSY] * 4 + [Outcome.DONE]
    made = executor(99)
    passes = {0.5 * i: senses(0.5 * i, picture=Picture(0.5 * i, DARK)) for i in range(6)}
    actions = look(made, Look(3, 99, 2.0), passes)
    assert [a.outcome for a in actions] == [Outcome.BUSY] * 5 + [Outcome.DONE]
    assert actions[-1].reading == Reading()


def test_a_silent_camera_ends_the_look_with_its_name_and_no_reading() -> None:
    made = executor()
    made.take(Look(3, 5, 2.0), 0.0)
    made.step(senses(0.0, camera="silent"))
    assert made.step(senses(PICTURE_WAIT_S - 0.1, camera="silent")).outcome == Outcome.BUSY
    ended = made.step(senses(PICTURE_WAIT_S, camera="silent"))
    assert (ended.outcome, ended.reason, ended.reading) == (Outcome.DONE, "camera: silent", Reading())


def test_a_jump_ends_a_look() -> None:
    made = executor()
    made.take(Look(3, 5, 2.0), 0.0)
    made.step(senses(0.0))
    assert made.step(senses(0.1), jump="the place has jumped").outcome == Outcome.FAILED


def test_costmaps_are_cleared_once_and_given_time() -> None:
    made = executor()
    made.take(ClearCostmaps(), 0.0)
    assert made.step(senses(0.0)) == Action(clear=True)
    assert made.step(senses(0.5)) == Action()
    assert made.step(senses(1.0)) == Action(Outcome.DONE)


def test_stopping_takes_the_goal_back_or_ends_the_turn() -> None:
    made = executor()
    made.take(GOAL, 0.0)
    made.step(senses(0.0))
    assert made.stop() == Action(cancel=True)
    assert made.stop() == Action()
    made.take(Spin(1.0, 0.5), 1.0)
    made.step(senses(1.0))
    assert made.stop() == Action(turn_radps=0.0)
    made.take(Stand(), 2.0)
    assert made.step(senses(2.0)) == Action(Outcome.DONE)
