"""A round in full physics without ROS: finds its place by itself, reads its box, comes home; driven as it is on ROS."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from python.experiments.inspect_samples import only
from yarm.experiments.inspect.measures import measure
from yarm.experiments.inspect.physics_run import DRIVING, PLATFORM, run_physics_round
from yarm.experiments.inspect.switches import FAULTS_IN_PHYSICS, Switches
from yarm.navigation import slam_native
from yarm.navigation.move_base_params import MoveBaseParams
from yarm.sim.scenes.layout_file import find_layout
from yarm.sim.scenes.layout_maker import make_layout

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
    (platform,) = [arg.get("default") for arg in launch.iter("arg") if arg.get("name") == "platform_tolerances"]
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


@pytest.mark.skipif(slam_native.library_path() is None, reason="needs the built package (make build)")
def test_home_is_taken_where_a_hand_has_put_it_when_it_is_taken_early_and_the_turns_are_lost() -> None:
    layout = only(make_layout("corridor", 0), (3,))
    plain = run_physics_round(layout, "report", 1)
    early = run_physics_round(layout, "report", 1, FAULTS_IN_PHYSICS["home taken early, turns lost"])
    assert any(order.doing == "spin" for order in plain.orders)
    assert not any(order.doing == "spin" for order in early.orders)
    homes = [next((o.x, o.y) for o in record.orders if o.stage == "home") for record in (plain, early)]
    start = layout.start
    assert math.dist(homes[0], (start.x, start.y)) < 0.05 and early.end_s < plain.end_s - 50.0
    assert homes[1] != homes[0]


@pytest.mark.parametrize(
    "controller, switches", [("yarm", Switches(empty_map=True)), ("report", Switches(printed_vote=True))]
)
def test_faults_that_a_round_does_not_have_are_refused(controller: str, switches: Switches) -> None:
    with pytest.raises(ValueError, match="does not have these faults"):
        run_physics_round(find_layout("practice"), controller, 0, switches)


def test_an_unknown_controller_is_refused() -> None:
    with pytest.raises(ValueError, match="'nobody' is not known"):
        run_physics_round(find_layout("practice"), "nobody", 0)
