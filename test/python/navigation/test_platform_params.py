"""A configuration of the platform's own move_base, in our names."""

from __future__ import annotations

import copy
from typing import Any, Dict

import pytest
import yaml

from yarm.navigation.platform_params import documented, take_platform

COMMON = """
robot_radius: 0.18
map_type: voxel
obstacle_layer:
  enabled: true
  obstacle_range: 2.0
  raytrace_range: 2.8
  z_voxels: 2
  observation_sources: scan bump
  scan: {data_type: LaserScan, topic: scan, marking: true, clearing: true, min_obstacle_height: 0.25}
  bump: {data_type: PointCloud2, topic: mobile_base/sensors/bumper_pointcloud, marking: true, clearing: false}
inflation_layer: {enabled: true, cost_scaling_factor: 4.0, inflation_radius: 0.45}
static_layer: {enabled: true}
"""
OWN = """
shutdown_costmaps: false
controller_frequency: 5.0
recovery_behavior_enabled: true
clearing_rotation_allowed: false
max_planning_retries: -1
conservative_reset_dist: 3.0
base_local_planner: dwa_local_planner/DWAPlannerROS
base_global_planner: navfn/NavfnROS
recovery_behaviors:
  - {name: gentle_reset, type: clear_costmap_recovery/ClearCostmapRecovery}
  - {name: once_round, type: rotate_recovery/RotateRecovery}
gentle_reset: {reset_distance: 1.5}
global_costmap:
  global_frame: map
  plugins:
    - {name: static_layer, type: "costmap_2d::StaticLayer"}
    - {name: obstacle_layer, type: "costmap_2d::VoxelLayer"}
    - {name: sonar_layer, type: "range_sensor_layer::RangeSensorLayer"}
    - {name: inflation_layer, type: "costmap_2d::InflationLayer"}
  sonar_layer: {enabled: false}
local_costmap: {rolling_window: true, width: 4.0, height: 4.0, resolution: 0.05}
NavfnROS: {allow_unknown: true, default_tolerance: 0.0}
GlobalPlanner: {use_dijkstra: true}
DWAPlannerROS: {max_vel_x: 0.25, min_vel_x: 0.0, max_rot_vel: 0.9, xy_goal_tolerance: 0.1, yaw_goal_tolerance: 0.2}
TrajectoryPlannerROS: {max_vel_x: 0.5, dwa: true}
"""


def platforms() -> Dict[str, Any]:
    """As ``rosparam load`` leaves the platform's files: the common ones in both costmaps."""
    values: Dict[str, Any] = yaml.safe_load(OWN)
    for costmap in ("global_costmap", "local_costmap"):
        values[costmap].update(yaml.safe_load(COMMON))
    return values


def test_what_has_a_meaning_here_is_taken_and_the_rest_is_named() -> None:
    taken = take_platform(platforms())
    assert taken.faults == ()
    assert taken.values == {
        "controller_frequency": 5.0,
        "recovery_behavior_enabled": True,
        "clearing_rotation_allowed": False,
        "recovery_behaviors": ["clear", "turn"],
        "robot_radius": 0.18,
        "inflation_radius": 0.45,
        "cost_scaling_factor": 4.0,
        "obstacle_range": 2.0,
        "raytrace_range": 2.8,
        "max_vel_x": 0.25,
        "max_vel_theta": 0.9,
        "xy_goal_tolerance": 0.1,
        "yaw_goal_tolerance": 0.2,
    }
    assert taken.sources["inflation_radius"] == "global_costmap/inflation_layer/inflation_radius"
    assert {
        "base_global_planner",
        "shutdown_costmaps",
        "gentle_reset/reset_distance",
        "global_costmap/obstacle_layer/bump/topic",
        "global_costmap/sonar_layer/enabled",
        "local_costmap/robot_radius",
        "NavfnROS/allow_unknown",
        "TrajectoryPlannerROS/max_vel_x",
    } <= set(taken.unused)
    assert not set(taken.unused) & {*taken.sources.values(), "base_local_planner"}


def test_before_layers_the_costmap_held_everything_itself() -> None:
    flat = {"obstacle_range": 2.1, "inflation_radius": 0.4, "observation_sources": "scan", "scan": {"topic": "scan"}}
    taken = take_platform({"global_costmap": flat})
    assert taken.faults == () and taken.values == {"obstacle_range": 2.1, "inflation_radius": 0.4}
    assert taken.unused == ("global_costmap/observation_sources", "global_costmap/scan/topic")


def test_the_named_local_planners_numbers_count_and_before_ours() -> None:
    values = {**platforms(), "base_local_planner": "base_local_planner/TrajectoryPlannerROS", "max_vel_x": 0.1}
    taken = take_platform(values)
    assert taken.values["max_vel_x"] == 0.5 and taken.sources["max_vel_x"] == "TrajectoryPlannerROS/max_vel_x"
    assert "DWAPlannerROS/max_vel_x" in taken.unused and "xy_goal_tolerance" not in taken.values
    values["base_local_planner"] = "teb_local_planner/TebLocalPlannerROS"
    taken = take_platform(values)
    assert taken.values["max_vel_x"] == 0.1, "a planner without numbers leaves ours"
    assert "base_local_planner" in taken.unused


def test_ours_alone_is_left_as_it_is() -> None:
    ours = {"robot_radius": 0.2, "recovery_behaviors": ["turn"], "no_such_parameter": 1, "elsewhere": {"x": 1}}
    taken = take_platform(ours)
    assert taken.values == ours and taken.unused == taken.faults == () and taken.sources == {}


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("global_costmap/robot_raduis", 0.2, "global_costmap/robot_raduis: unknown parameter; known: always_send"),
        ("local_costmap/inflation_layer/inflation_raduis", 0.2, "inflation_layer/inflation_raduis: unknown parameter"),
        ("global_costmap/obstacle_layer/scan/topics", "x", "obstacle_layer/scan/topics: unknown parameter; known: cl"),
        ("global_costmap/obstacle_layer/laser", {"topic": "x"}, "global_costmap/obstacle_layer/laser: unknown param"),
        ("DWAPlannerROS/max_vel", 0.2, "DWAPlannerROS/max_vel: unknown parameter; known: acc_lim_th, "),
        ("NavfnROS/robot_radius", 0.2, "NavfnROS/robot_radius: unknown parameter"),
        ("gentle_reset/distance", 1.0, "gentle_reset/distance: unknown parameter"),
        ("DWAPlannerROS", 3, "DWAPlannerROS: must be a namespace"),
        ("base_local_planner", {"name": "x"}, "base_local_planner: must be one value, not a namespace"),
    ],
)
def test_a_typo_is_refused_by_its_whole_name_wherever_it_stands(path: str, value: Any, said: str) -> None:
    values = copy.deepcopy(platforms())
    *spaces, name = path.split("/")
    inner = values
    for space in spaces:
        inner = inner[space]
    inner[name] = value
    faults = take_platform(values).faults
    assert len(faults) == 1 and said in faults[0], faults


def test_a_recovery_that_nobody_knows_is_refused() -> None:
    values = platforms()
    values["recovery_behaviors"] += [{"name": "dance", "type": "dance/Dance"}, "turn"]
    assert [fault.partition(" must")[0] for fault in take_platform(values).faults] == [
        "recovery_behaviors: type 'dance/Dance'",
        "recovery_behaviors: type 'turn'",
    ]


def test_the_page_of_parameters_has_every_name_that_is_accepted() -> None:
    rows = dict(documented())
    assert rows["global_costmap/robot_radius"] == "taken as robot_radius"
    assert all("without effect" in meaning or "taken" in meaning for meaning in rows.values())
    text = " ".join(rows)
    assert all(name.rpartition("/")[2] in text for name in take_platform(platforms()).unused)
