"""Goals of move_base: taken into the map, or refused by name; plans as messages; the frames a camera owes."""

from __future__ import annotations

import math
import threading
from typing import List, Optional

import numpy as np
import pytest
import rospy
from actionlib.status_tracker import StatusTracker
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import PoseStamped
from yarm.msg import MoveRobotActionGoal

from yarm.geometry import Pose2
from yarm.ros.common.checks import Doorkeeper
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.goal_queue import MOST_EARLY, GoalEvent, GoalQueue
from yarm.ros.navigation.goal_server import due_goals, goal_in_map
from yarm.ros.navigation.outputs import path_message, stamped_pose
from yarm.ros.rooms.rgb import frame_number

ROBOT = Pose2(1.0, 2.0, math.pi / 2)


def in_map(frame: str) -> Optional[Pose2]:
    return ROBOT if frame == "base_footprint" else None


def goal(frame: str = "map", x: float = 0.5, **orientation: float) -> PoseStamped:
    made = stamped_pose(Pose2(x, 0.0, 0.0), frame, rospy.Time(0))
    for axis, value in orientation.items():
        setattr(made.pose.orientation, axis, value)
    return made


def test_a_goal_in_the_map_is_taken_as_it_is() -> None:
    assert goal_in_map(goal("/map"), "map", in_map) == (Pose2(0.5, 0.0, 0.0), "")


def test_a_goal_in_another_frame_is_taken_into_the_map() -> None:
    found, fault = goal_in_map(goal("base_footprint"), "map", in_map)
    assert not fault and found is not None
    assert (found.x, found.y, found.yaw_rad) == pytest.approx((1.0, 2.5, math.pi / 2))


@pytest.mark.parametrize(
    ("bad", "named"),
    [
        (goal(x=math.nan), "must be finite"),
        (goal(x=math.inf), "must be finite"),
        (goal(x=1e6), "within 1000 m"),
        (goal(w=0.0), "must have length 1"),
        (goal(w=math.nan), "must have length 1"),
        (goal(w=0.5), "must have length 1"),
        (goal(""), "it has no frame"),
        (goal("moon"), "no transform leads from map to its frame 'moon'"),
    ],
)
def test_what_cannot_be_a_goal_is_refused_by_name(bad: PoseStamped, named: str) -> None:
    found, fault = goal_in_map(bad, "map", in_map)
    assert found is None and fault.startswith("goal refused: ") and named in fault


def test_a_plan_has_poses_close_together_that_look_along_it() -> None:
    path = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 0.52)])
    message = path_message(path, Pose2(1.0, 0.52, -1.0), "map", rospy.Time(3))
    poses = [pose2_of_pose(entry.pose) for entry in message.poses]
    steps = [a.distance(b) for a, b in zip(poses, poses[1:])]
    assert max(steps) <= 0.05 + 1e-9 and sum(steps) == pytest.approx(1.52)
    assert poses[0].yaw_rad == pytest.approx(0.0) and poses[-2].yaw_rad == pytest.approx(math.pi / 2)
    assert poses[-1].yaw_rad == pytest.approx(-1.0) and (poses[-1].x, poses[-1].y) == pytest.approx((1.0, 0.52))
    assert {entry.header.frame_id for entry in message.poses} == {"map"}


def test_a_plan_of_one_point_or_none_is_a_message_too() -> None:
    assert path_message(np.zeros((0, 2)), None, "map", rospy.Time(0)).poses == []
    (only,) = path_message(np.array([(0.3, 0.4)]), Pose2(0.3, 0.4, 2.0), "map", rospy.Time(0)).poses
    assert pose2_of_pose(only.pose).yaw_rad == pytest.approx(2.0)


class Handle:
    """A goal's handle that knows its stamp."""

    def __init__(self, stamp_s: float) -> None:
        self.stamp_s = stamp_s

    def get_goal_id(self) -> GoalID:
        return GoalID(stamp=rospy.Time.from_sec(self.stamp_s))


def test_in_lock_step_a_goal_counts_from_the_pass_after_its_stamp() -> None:
    early, cancel, late, after = (
        GoalEvent(Handle(stamp_s), cancel) for stamp_s, cancel in ((2.9, False), (9.0, True), (3.0, False), (0.0, True))
    )
    assert due_goals([early, cancel, late, after], 3.0) == ([early, cancel], [late, after])
    assert due_goals([late, after], 3.1) == ([late, after], [])
    assert due_goals([], 3.1) == ([], [])


def test_frames_are_due_thirty_times_a_hundred_ticks() -> None:
    due = [tick for tick in range(1, 101) if frame_number(tick, 30.0) > frame_number(tick - 1, 30.0)]
    assert len(due) == 30 and set(np.diff(due)) == {3, 4}
    assert [frame_number(tick, 100.0) for tick in (1, 2, 3)] == [1, 2, 3]


class Standing(GoalQueue):
    """A queue that no master knows, with goals that were sent to it."""

    def __init__(self, *goals: str) -> None:
        self.lock, self.started, self.last_cancel = threading.RLock(), True, rospy.Time()
        self.publish_status = lambda: None
        self._cancels, self._wake, self.cancelled = Doorkeeper("move_robot/cancel"), lambda: None, []
        self.cancel_callback = lambda handle: self.cancelled.append(handle.get_goal_id().id)
        self.status_list = [
            StatusTracker(None, None, MoveRobotActionGoal(goal_id=GoalID(rospy.Time(5), name))) for name in goals
        ]

    def cancel(self, name: str, stamp_s: float = 0.0) -> None:
        self.internal_cancel_callback(GoalID(rospy.Time.from_sec(stamp_s), name))


@pytest.fixture
def now_10_s(monkeypatch: pytest.MonkeyPatch) -> List[str]:
    """It is 10 s of simulated time; what actionlib complains of."""
    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    monkeypatch.setattr(rospy.rostime, "_rostime_current", rospy.Time(10))
    complaints: List[str] = []
    monkeypatch.setattr(rospy, "logerr", lambda text, *_: complaints.append(text))
    return complaints


def test_a_flood_of_cancels_of_goals_nobody_sent_leaves_the_others_as_they_are(now_10_s: List[str]) -> None:
    server = Standing("a", "b")
    for i in range(3 * MOST_EARLY):
        server.cancel(f"nobody {i}")
    assert len(server.status_list) <= 2 + MOST_EARLY + 1
    assert server.cancelled == [] and now_10_s == []
    server.cancel("b")
    assert server.cancelled == ["b"]
    server.cancel("")
    assert server.cancelled == ["b", "a"] and now_10_s == []


def test_a_cancel_of_the_future_is_refused_and_one_of_now_counts(now_10_s: List[str]) -> None:
    server = Standing("a")
    server.cancel("", 1e4)
    assert server.cancelled == [] and server.last_cancel == rospy.Time()
    server.cancel("", 10.0)
    assert server.cancelled == ["a"] and server.last_cancel == rospy.Time(10)
    assert now_10_s == []


def test_a_cancel_that_comes_before_its_goal_is_kept(now_10_s: List[str]) -> None:
    server = Standing()
    server.cancel("late")
    server.cancel("other")
    server.cancel("late")
    assert (server.cancelled, now_10_s) == ([], [])
    assert sorted(st.status.goal_id.id for st in server.status_list) == ["late", "other"]
