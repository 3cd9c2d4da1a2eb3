"""Who may import whom: the layers of docs/architecture.md, checked on the sources' own import statements."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Iterator, List

ROS = re.compile(
    r"^(rospy|roslib|rosgraph|roslaunch|rosbag|rostest|rosnode|rospkg|rosparam|rosservice|rostopic|tf|tf2_ros|tf2_py|actionlib|"
    r"diagnostic_updater|dynamic_reconfigure|genpy|\w+_msgs|yarm\.(msg|srv))(\.|$)"
)
ALLOWED = {
    "params": set(),
    "resources": set(),
    "geometry": {"params", "resources"},
    "planning": {"geometry", "params", "resources"},
    "control": {"geometry", "params", "resources"},
    "sim": {"geometry", "params", "resources"},
    "commander": {"geometry", "planning", "control", "sim", "params", "resources"},
    "experiments": {"geometry", "planning", "control", "sim", "commander", "params", "resources"},
    "ros": {"geometry", "planning", "control", "sim", "commander", "experiments", "params", "resources"},
}
INCLUDE_ROS = re.compile(
    r'#include\s*[<"]((ros|nodelet|pluginlib|tf2|tf2_ros|pcl_ros|pcl_conversions|actionlib|diagnostic_updater|yarm/ros|\w+_msgs)/'
    r"|yarm/[A-Z]\w*\.h)"
)


def python_violations(package: Path) -> List[str]:
    """Imports below ``package`` (the folder ``yarm``) that break the rules, as "file:line: why"."""
    found = []
    for path in sorted(package.rglob("*.py")):
        part = path.relative_to(package).parts[0].replace(".py", "")
        for line, module in _imports(path):
            where = f"{path.relative_to(package)}:{line}"
            if part != "ros" and ROS.match(module):
                found.append(f"{where}: {module} is ROS, which only yarm.ros may import")
            match = re.match(r"yarm\.(\w+)", module)
            target = match.group(1) if match else part
            if part in ALLOWED and target in ALLOWED and target != part and target not in ALLOWED[part]:
                found.append(f"{where}: yarm.{part} must not import yarm.{target}")
    return found


def cpp_violations(root: Path) -> List[str]:
    """ROS headers included by the ROS-free C++ library, as "file:line: why"."""
    found = []
    for folder in ("include/yarm/perception", "src/perception"):
        for path in sorted((root / folder).rglob("*.?pp")):
            for number, line in enumerate(path.read_text().splitlines(), 1):
                if INCLUDE_ROS.search(line):
                    found.append(f"{path.relative_to(root)}:{number}: {line.strip()} is ROS")
    return found


def _imports(path: Path) -> Iterator[tuple]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom) and node.module:
            if node.module == "yarm":
                yield from ((node.lineno, f"yarm.{alias.name}") for alias in node.names)
            else:
                yield node.lineno, node.module
