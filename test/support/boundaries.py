"""Who may import whom: the floors of docs/architecture.md, checked on the sources' own import statements."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple

ROS = re.compile(
    r"^(rospy|roslib|rosgraph|roslaunch|rosbag|rostest|rosnode|rospkg|rosparam|rosservice|rostopic|tf|tf2_ros|tf2_py|actionlib|"
    r"diagnostic_updater|dynamic_reconfigure|genpy|\w+_msgs|yarm\.(msg|srv))(\.|$)"
)
FLOORS: Tuple[Tuple[str, ...], ...] = (
    ("params", "resources", "yaml_fields", "records"),
    ("geometry",),
    ("robots",),
    ("planning", "navigation", "control", "sim", "safety", "tags", "calibration"),
    ("commander", "exploration", "inspection", "manipulation"),
    ("experiments", "console"),
    ("ros",),
)
"""A part imports from the floors below its own; on its own floor only what BESIDE grants."""
BESIDE: Set[Tuple[str, str]] = {("yaml_fields", "params")}
FLOOR_OF: Dict[str, int] = {part: floor for floor, parts in enumerate(FLOORS) for part in parts}
INCLUDE_ROS = re.compile(
    r'#include\s*[<"]((ros|nodelet|pluginlib|tf2|tf2_ros|pcl_ros|pcl_conversions|actionlib|diagnostic_updater|yarm/ros|\w+_msgs)/'
    r"|yarm/[A-Z]\w*\.h)"
)

# Folders with C++ below include/yarm and src, and whose headers each may include.
CPP_ALLOWED = {
    "clearance": set(),
    "joint": set(),
    "perception": set(),
    "rays": set(),
    "slam": set(),
    "sync": {"perception"},
    "ros": {"perception", "rays", "slam", "sync"},
}
INCLUDE_OWN = re.compile(r'#include\s*"yarm/(\w+)/')


def python_violations(package: Path) -> List[str]:
    """Whatever below ``package`` (the folder ``yarm``) breaks the rules: "file:line: why", or "circle: a -> b -> a"."""
    found = []
    imports: Dict[str, Set[str]] = {}
    modules = {_module_of(package, path): path for path in sorted(package.rglob("*.py"))}
    for module, path in modules.items():
        part = path.relative_to(package).parts[0].replace(".py", "")
        if part not in FLOOR_OF and part != "__init__":
            found.append(f"{path.relative_to(package)}:1: yarm.{part} has no floor in test/support/boundaries.py")
        for line, name in _imports(path):
            where = f"{path.relative_to(package)}:{line}"
            if part != "ros" and ROS.match(name):
                found.append(f"{where}: {name} is ROS, which only yarm.ros may import")
            match = re.match(r"yarm\.(\w+)", name)
            target = match.group(1) if match else part
            if _is_upward(part, target):
                found.append(f"{where}: yarm.{part} must not import yarm.{target}")
            imports.setdefault(module, set()).update(_targets(name, modules))
    return found + [f"circle: {' -> '.join(circle)}" for circle in circles(imports)]


def circles(imports: Dict[str, Set[str]]) -> List[List[str]]:
    """Modules that import each other, one circle for each that is found, first module repeated at the end.

    Args:
        imports: for each module the modules of the same package that it imports.
    """
    found: List[List[str]] = []
    done: Set[str] = set()

    def visit(module: str, trail: List[str]) -> None:
        if module in trail:
            found.append([*trail[trail.index(module) :], module])
            return
        if module in done:
            return
        for target in sorted(imports.get(module, set()) - {module}):
            visit(target, [*trail, module])
        done.add(module)

    for module in sorted(imports):
        visit(module, [])
    return found


def cpp_violations(root: Path) -> List[str]:
    """C++ below ``include/yarm`` and ``src`` that breaks the rules, as "file:line: why".

    Only ``ros`` may include ROS, each folder only what ``CPP_ALLOWED`` lists; a folder that is not listed is a fault.
    """
    found = []
    for base in ("include/yarm", "src"):
        for path in sorted((root / base).rglob("*.[ch]pp")):
            relative = path.relative_to(root / base)
            folder = relative.parts[0] if len(relative.parts) > 1 else ""
            if folder not in CPP_ALLOWED:
                found.append(f"{path.relative_to(root)}:1: folder {folder!r} is not known: add it to CPP_ALLOWED")
                continue
            found += [f"{path.relative_to(root)}:{fault}" for fault in _cpp_faults(path, folder)]
    return found


def _is_upward(part: str, target: str) -> bool:
    if part == target or part not in FLOOR_OF or target not in FLOOR_OF or (part, target) in BESIDE:
        return False
    return FLOOR_OF[target] >= FLOOR_OF[part]


def _module_of(package: Path, path: Path) -> str:
    parts = ["yarm", *path.relative_to(package).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _targets(name: str, modules: Dict[str, Path]) -> Set[str]:
    """The module that an imported name comes from: a module itself, or the one that holds the name."""
    while name and name not in modules:
        name = name.rpartition(".")[0]
    return {name} if name and name != "yarm" else set()


def _cpp_faults(path: Path, folder: str) -> Iterator[str]:
    for number, line in enumerate(path.read_text().splitlines(), 1):
        own = INCLUDE_OWN.search(line)
        if folder != "ros" and INCLUDE_ROS.search(line):
            yield f"{number}: {line.strip()} is ROS, which only the folder ros may include"
        elif own and own.group(1) != folder and own.group(1) not in CPP_ALLOWED[folder]:
            yield f"{number}: {folder} must not include yarm/{own.group(1)}"


def _imports(path: Path) -> Iterator[Tuple[int, str]]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)
