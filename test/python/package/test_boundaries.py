"""ROS stays at the edge and nothing imports upward; each rule is also shown to fail when broken."""

from __future__ import annotations

from pathlib import Path

from support.boundaries import cpp_violations, python_violations

ROOT = Path(__file__).resolve().parents[3]


def test_python_layers_hold():
    assert python_violations(ROOT / "src" / "yarm") == []


def test_cpp_core_is_free_of_ros():
    assert cpp_violations(ROOT) == []


def test_broken_python_rules_are_found(tmp_path):
    for name, text in {
        "planning/a.py": "import rospy\n",
        "geometry/b.py": "from yarm.planning import types\n",
        "sim/c.py": "from yarm import control\n",
        "commander/d.py": "from yarm.msg import MapMetaData\n",
        "inspection/e.py": "from yarm.exploration import frontiers\n",
        "attic/f.py": "",
        "ros/fine.py": "import rospy\nfrom yarm.commander import states\n",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    found = python_violations(tmp_path)
    assert [line.split(":")[0] for line in found] == [
        "attic/f.py",
        "commander/d.py",
        "geometry/b.py",
        "inspection/e.py",
        "planning/a.py",
        "sim/c.py",
    ]


def test_circles_are_found(tmp_path):
    for name, text in {
        "sim/a.py": "from yarm.sim.b import B\n",
        "sim/b.py": "def late():\n    import yarm.sim.c\n",
        "sim/c.py": "from yarm.sim import a\n",
        "sim/d.py": "from yarm.sim.a import A\n",
    }.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    assert python_violations(tmp_path) == ["circle: yarm.sim.a -> yarm.sim.b -> yarm.sim.c -> yarm.sim.a"]


def test_broken_cpp_rule_is_found(tmp_path):
    path = tmp_path / "src" / "perception" / "bad.cpp"
    path.parent.mkdir(parents=True)
    path.write_text('#include <vector>\n#include <sensor_msgs/PointCloud2.h>\n#include "yarm/MapMetaData.h"\n')
    assert [line.split(":")[1] for line in cpp_violations(tmp_path)] == ["2", "3"]


def test_a_cpp_folder_that_is_not_known_is_found(tmp_path):
    for name in ("src/perception/fine.cpp", "src/nodes/new.cpp", "include/yarm/attic/map.hpp", "src/loose.cpp"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#include <vector>\n")
    found = [line.split(":")[0] for line in cpp_violations(tmp_path)]
    assert found == ["include/yarm/attic/map.hpp", "src/loose.cpp", "src/nodes/new.cpp"]


def test_a_cpp_folder_that_includes_upward_is_found(tmp_path):
    path = tmp_path / "src" / "perception" / "bad.cpp"
    path.parent.mkdir(parents=True)
    path.write_text('#include "yarm/perception/types.hpp"\n#include "yarm/sync/clock.hpp"\n')
    assert [line.split(":")[1] for line in cpp_violations(tmp_path)] == ["2"]
