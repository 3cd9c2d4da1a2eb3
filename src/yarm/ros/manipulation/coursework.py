"""``rosrun yarm coursework`` with bags and a film: checkpoints may come from a bag, the tour's motion goes into one."""

from __future__ import annotations

from pathlib import Path
from typing import Optional, Sequence

from yarm.console.floor_film import FloorFilm
from yarm.experiments.coursework import cli
from yarm.manipulation.motion.checkpoints import ArmScene, load_arm_scene
from yarm.ros.manipulation.bags import read_checkpoints, write_motion


def load(path: Path) -> ArmScene:
    """A scene of the arm: from YAML, or for a file that ends in .bag its checkpoints, begun from the candle."""
    if path.suffix == ".bag":
        return ArmScene(path.stem, (0.0, 0.0, 0.0, 0.0, 0.0), read_checkpoints(path), ())
    return load_arm_scene(path)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """The command; see ``yarm.experiments.coursework.cli.main``."""
    return cli.main(arguments, load, cli.Keeping(write_motion, FloorFilm("coursework")))
