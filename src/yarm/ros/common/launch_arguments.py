"""Launch arguments are checked before anything starts: all faults at once, with what is allowed and a non-zero exit.

A launch file calls ``rosrun yarm check_arguments name:=value ...`` as the command of a parameter, so that roslaunch
itself ends with an error when one is wrong.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Callable, Dict, List, Sequence

from yarm.commander.params import CheckSteps, Execution, Removal
from yarm.exploration.registry import CONTROLLERS
from yarm.inspection.model import CONTROLLERS as ROUNDS
from yarm.params import has_form
from yarm.planning.model.hidden import HiddenPolicy
from yarm.planning.registry import PLANNER_NAMES
from yarm.resources import resource
from yarm.robots.hc10 import NAME
from yarm.sim.scenes.arena import arena_path, shipped_arenas
from yarm.sim.scenes.layout_file import KNOWN, is_layout
from yarm.sim.scenes.scene import SceneError, load_scene
from yarm.sim.scenes.specs import DRAWN, NOT_DRAWN

MAX_SEED = 2**31 - 1
Check = Callable[[str], str]


def _one_of(*allowed: str) -> Check:
    def check(value: str) -> str:
        return "" if value in allowed else "must be one of " + ", ".join(allowed)

    return check


def _planner(value: str) -> str:
    fault = _one_of(*PLANNER_NAMES)(value)
    return f"{fault}, or module:Class" if fault and not has_form(value, "module:Class") else ""


def _whole(low: int, high: int) -> Check:
    def check(value: str) -> str:
        try:
            return "" if low <= int(value) <= high else f"must be within {low} to {high}"
        except ValueError:
            return f"must be a whole number within {low} to {high}"

    return check


def _number(low: float, high: float) -> Check:
    def check(value: str) -> str:
        try:
            return "" if low <= float(value) <= high else f"must be within {low:g} to {high:g}"
        except ValueError:
            return f"must be a number within {low:g} to {high:g}"

    return check


def _scene(value: str) -> str:
    shipped = sorted(path.stem for path in resource("scenes", "cell").glob("*.yaml"))
    if value in shipped or Path(value).is_file():
        return ""
    return "no such scene; shipped: " + ", ".join(shipped) + "; or give the path of a YAML file"


def _case(value: str) -> str:
    fault = _scene(value)
    return f"{fault}; the rooms' cases are explore and inspect" if fault else ""


def _arena(value: str) -> str:
    if arena_path(value).is_file():
        return ""
    return "no such arena; shipped: " + ", ".join(shipped_arenas()) + "; or give the path of a YAML file"


def _layout(value: str) -> str:
    return "" if not value or is_layout(value) else f"no such layout; known: {KNOWN}"


def _recording(value: str) -> str:
    return "" if Path(value).is_file() else "no such file; give a recording, bag:=/path/to/run.bag"


def _arms(value: str) -> str:
    words = value.split()
    good = words and len(set(words)) == len(words) and all(word.startswith(NAME) for word in words)
    return "" if good else f"must be names that begin with {NAME}, each once, separated by spaces"


_BOOL = _one_of("true", "false")


def _window(value: str) -> str:
    if value == "true" and not os.environ.get("DISPLAY"):
        return "needs a screen, and DISPLAY is not set: false shows nothing, xvfb-run gives a screen nobody sees"
    return _BOOL(value)


CHECKS: Dict[str, Check] = {
    # One name with two meanings: argument@meaning.
    "scene": _scene,
    "case": _case,
    "arena": _arena,
    "layout": _layout,
    "seed": _whole(-1, MAX_SEED),
    "planner": _planner,
    "controller": _one_of(*sorted(CONTROLLERS)),
    "controller@inspection": _one_of(*ROUNDS),
    "time_limit_s": _number(1.0, 36000.0),
    "backend": _one_of("fused", "pcl"),
    "mode": _one_of("bounded", "boundless"),
    "shapes": _one_of(DRAWN, NOT_DRAWN),
    "check_steps": _one_of(*(mode.value for mode in CheckSteps)),
    "execution": _one_of(*(way.value for way in Execution)),
    "hidden": _one_of(*(policy.value for policy in HiddenPolicy)),
    "debris_size": _number(0.0, 1.0),
    "removal": _one_of(*(way.value for way in Removal)),
    "real_time_factor": _number(0.0, 100.0),
    "recording": _recording,
    "drive": _one_of("mux", "move_base"),
    "mission": _one_of("cell", "exploration", "inspection"),
    "console_port": _whole(0, 65535),
    "rate": _number(0.01, 100.0),
    "start": _number(0.0, 1e6),
    **dict.fromkeys(("rviz", "gui"), _window),
    "arms": _arms,
    **dict.fromkeys(
        (
            "sander",
            "hands",
            "sync",
            "bag",
            "nodelets",
            "noise",
            "cleanup",
            "loop",
            "replanning",
            "sand_elsewhere",
            "vary",
            "slam",
            "boxes_known",
            "inspector",
            "return_to_start",
            "autostart",
            "gate",
            "rough_pose",
            "fine_map",
            "recogniser",
            "score",
            "console",
            "keep",
            "registry",
            "sim_time",
            "watch",
        ),
        _BOOL,
    ),
}


def faults(arguments: Sequence[str]) -> List[str]:
    """What is wrong with the given ``name:=value`` words, each fault naming argument, value and what is allowed."""
    found = []
    for word in arguments:
        name, separator, value = word.partition(":=")
        if not separator or name not in CHECKS:
            found.append(f"launch argument {word!r}: unknown; known: {', '.join(CHECKS)}")
            continue
        fault = CHECKS[name](value)
        if fault:
            found.append(f"launch argument {name.partition('@')[0]} = {value!r}: {fault}")
    values = dict(word.split(":=", 1) for word in arguments if ":=" in word)
    return found + _arms_without_sander(values) + _nothing_to_carry_with_or_to(values)


def _nothing_to_carry_with_or_to(values: Dict[str, str]) -> List[str]:
    """Debris that is to be carried to a bin without a hand, or without a bin."""
    if values.get("removal") != Removal.BIN.value:
        return []
    scene = values.get("scene", "")
    try:
        loaded = load_scene(scene) if scene and not _scene(scene) else None
    except SceneError as error:
        return [str(error)]
    found = []
    if values.get("hands") == "false" and not (loaded and any(robot.has_hand for robot in loaded.robots)):
        found.append("launch argument removal = 'bin': the robots need hands, and hands = 'false'; say hands:=true")
    if loaded is not None and not loaded.bins:
        text = "has no bins to carry debris to; give it one under `bins`, or say removal:=delete"
        found.append(f"launch argument removal = 'bin': scene {scene} {text}")
    return found


def _arms_without_sander(values: Dict[str, str]) -> List[str]:
    """A manipulator of the scene that nobody would bring to work."""
    scene, arms = values.get("scene", ""), values.get("arms", "")
    if not scene or not arms or values.get("sander") == "false" or _scene(scene):
        return []
    try:
        working = load_scene(scene).working_arms
    except SceneError as error:
        return [str(error)]
    if set(working) <= set(arms.split()):
        return []
    wanted = " ".join(working)
    return [f'launch argument arms = {arms!r}: scene {scene} has {", ".join(working)}; say arms:="{wanted}"']
