"""Parameters of driving to goals: the platform's values, and what they mean to planner, follower and costmap."""

from __future__ import annotations

import pytest

from yarm.navigation.move_base_params import MoveBaseParams
from yarm.params import ParamError, build


def test_the_platforms_values_are_the_defaults() -> None:
    params = MoveBaseParams()
    assert (params.controller_frequency, params.planner_frequency) == (5.0, 1.0)
    assert (params.planner_patience, params.controller_patience) == (5.0, 3.0)
    assert (params.oscillation_timeout, params.oscillation_distance) == (10.0, 0.2)
    assert (params.robot_radius, params.inflation_radius, params.cost_scaling_factor) == (0.20, 0.50, 5.0)
    assert (params.obstacle_range, params.raytrace_range, params.max_vel_x) == (2.5, 3.0, 0.3)
    assert (params.xy_goal_tolerance, params.yaw_goal_tolerance) == (0.15, 0.3)


def test_a_silent_scan_stops_the_robot_in_time_at_any_allowed_rate() -> None:
    with pytest.raises(ParamError, match="4 to 20"):
        build(MoveBaseParams, {"controller_frequency": 3.0})
    slowest = build(MoveBaseParams, {"controller_frequency": 4.0, "scan_timeout": 0.25})
    assert slowest.scan_timeout + slowest.period_s <= 0.5


def test_they_reach_planner_follower_and_costmap() -> None:
    params = build(MoveBaseParams, {"robot_radius": 0.3, "inflation_radius": 0.2, "max_vel_x": 0.2})
    assert params.plan_settings().radius_m == 0.3 and params.plan_settings().comfort_m > 0.3
    assert params.follow_settings().max_speed_mps == 0.2 and params.follow_settings().tick_s == 0.2
    assert 2.0 * params.follow_settings().arrive_m <= params.xy_goal_tolerance
    assert params.costmap_settings().obstacle_range_m == 2.5


def test_recoveries_are_those_that_are_allowed() -> None:
    assert MoveBaseParams().recoveries() == ("clear", "back_off", "turn")
    assert build(MoveBaseParams, {"clearing_rotation_allowed": False}).recoveries() == ("clear", "back_off")
    assert build(MoveBaseParams, {"recovery_behavior_enabled": False}).recoveries() == ()
    assert build(MoveBaseParams, {"recovery_behaviors": ["turn"]}).recoveries() == ("turn",)
    with pytest.raises(ParamError, match="back_off"):
        build(MoveBaseParams, {"recovery_behaviors": ["turn", "spin"]})
