"""A round in full physics without ROS: finds its place by itself, reads its box, comes home; driven as it is on ROS."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from yarm.experiments.inspect.measures import measure
from yarm.experiments.inspect.physics_run import DRIVING, PLATFORM, run_physics_round
from yarm.navigation import slam_native
from yarm.navigation.move_base_params import MoveBaseParams
from yarm.sim.scenes.layout_file import find_layout

ROOT = Path(__file__).resolve().parents[4]
FEW = ROOT / "test" / "system" / "inspected_room.yaml"


def test_it_drives_as_the_launch_file_has_move_base_drive() -> None:
    launch = ElementTree.parse(ROOT / "launch" / "inspection" / "inspection.launch").getroot()
    (base,) = [node for node in launch.iter("node") if node.get("name") == "move_base"]
    told = {
        p.get("name"): p.get("value") for p in base.iter("param") if p.get("unless") == "$(arg platform_tolerances)"
    }
    assert set(told) == {"controller_frequency", "xy_goal_tolerance", "yaw_goal_tolerance"}
    assert {name: float(str(value)) for name, value in told.items()} == {name: getattr(DRIVING, name) for name in told}
    experiment = ElementTree.parse(ROOT / "launch" / "inspection" / "inspect_experiment.launch").getroot()
    (platform,) = [arg.get("value") for arg in experiment.iter("arg") if arg.get("name") == "platform_tolerances"]
    assert platform == "$(eval arg('controller') != 'yarm')"
    assert MoveBaseParams() == PLATFORM and PLATFORM.xy_goal_tolerance == 0.15 and PLATFORM.yaw_goal_tolerance == 0.3


@pytest.mark.skipif(slam_native.library_path() is None, reason="needs the built package (make build)")
def test_a_round_over_four_boxes() -> None:
    layout = find_layout(str(FEW))
    record = run_physics_round(layout, "yarm", 1)
    measures = measure(record)
    assert (measures.right, measures.boxes, measures.named_wrong, measures.bumps) == (4, 4, 0, 0)
    assert measures.kept and record.info.mode == "physics"
    assert measures.place_p95_m < 0.05


def test_an_unknown_controller_is_refused() -> None:
    with pytest.raises(ValueError, match="'nobody' is not known"):
        run_physics_round(find_layout("practice"), "nobody", 0)
