"""``rosrun yarm coursework``: every task of the arm coursework, headless, with progress, a summary and pictures."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, List, Optional, Protocol, Sequence

import yaml

from yarm.experiments.coursework.clearing import clearing, draw_clearing
from yarm.experiments.coursework.pictures import draw_coverage, draw_obstacles, draw_tour
from yarm.experiments.coursework.tasks import TaskResult, floors, kinematics, obstacles, play_tour, tours
from yarm.experiments.run.tables import text_table
from yarm.manipulation.clearing.mission import Command, MissionError
from yarm.manipulation.clearing.play import unwatched
from yarm.manipulation.motion.checkpoints import ArmScene, CheckpointError, load_arm_scene
from yarm.manipulation.motion.tour import TourError
from yarm.manipulation.motion.trajectory import Trajectory, TrajectoryError
from yarm.manipulation.obstacles.physics import ArmWatch
from yarm.manipulation.obstacles.physics import unwatched as unwatched_arm
from yarm.resources import resource
from yarm.sim.engine.youbot_floor import YoubotFloor
from yarm.sim.scenes.youbot_floor import FloorScene, load_floor_scene
from yarm.yaml_fields import SceneError

Log = Callable[[str], None]
Load = Callable[[Path], ArmScene]
Save = Callable[[Trajectory, Path], Path]


class Watcher(Protocol):
    """Looks on while the youBot does its tasks, and leaves a file in the results' folder."""

    def arm(self, title: str, scene: ArmScene) -> ArmWatch:
        """What looks on while the arm does a task that has this title."""

    def __call__(self, world: YoubotFloor, command: Command) -> None:
        """After each tick on the floor: the world, and what the robot was told."""

    def write(self, folder: Path) -> Path:
        """Leave the file; which it is."""


@dataclass(frozen=True)
class Keeping:
    """What a run leaves beside its summary and pictures.

    Attributes:
        motion: keeps the tour's motion in a folder, and gives the file; None: it is not kept.
        film: looks on at the tour, our way among the obstacles, and the floor; None: nobody does.
    """

    motion: Optional[Save] = None
    film: Optional[Watcher] = None

    def among(self, scene: ArmScene) -> ArmWatch:
        """What looks on at the obstacle task, where its obstacles stand."""
        return unwatched_arm if self.film is None else self.film.arm("among obstacles", scene)


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    options = argparse.ArgumentParser(
        prog="coursework",
        description="The youBot coursework: kinematics, tours, obstacles, coverage, a floor cleared (exit code 0).",
    )
    options.add_argument(
        "--seed", type=int, default=3, help="of poses, planner and the obstacles' places; 0: as in the file"
    )
    options.add_argument("--results", type=Path, default=Path("results"), help="folder for coursework/<seed>/")
    options.add_argument("--checkpoints", type=Path, help="scene or bag for the tour; the shipped scene by default")
    options.add_argument("--obstacles", type=Path, help="scene for the obstacle task; the shipped one by default")
    options.add_argument("--floor", type=Path, help="scene of the youBot's floor; the shipped one by default")
    return options


def main(arguments: Optional[Sequence[str]] = None, load: Load = load_arm_scene, keeping: Keeping = Keeping()) -> int:
    """Run every task; 0 when all is as it must be, 1 when something is not, 2 for a scene that cannot be read.

    Args:
        arguments: of the command line; None for the process' own.
        load: reads a scene.
        keeping: what is left beside summary and pictures.
    """
    options = parser().parse_args(arguments)

    def say(text: str) -> None:
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()

    try:
        scenes = [
            load(given or resource("scenes", "manipulation", name))
            for given, name in ((options.checkpoints, "checkpoints.yaml"), (options.obstacles, "arm_obstacles.yaml"))
        ]
        youbot = load_floor_scene(options.floor or resource("scenes", "manipulation", "youbot_floor.yaml"))
    except (SceneError, CheckpointError) as error:
        sys.stderr.write(f"coursework: {error}\n")
        return 2
    try:
        folder = options.results / "coursework" / str(options.seed)
        results = run(scenes[0], scenes[1], youbot, options.seed, folder, say, keeping)
    except (TourError, TrajectoryError, MissionError) as error:
        sys.stderr.write(f"coursework: {error}\n")
        return 1
    return 1 if any(result.faults for result in results) else 0


def run(
    tour_scene: ArmScene,
    obstacle_scene: ArmScene,
    youbot_scene: FloorScene,
    seed: int,
    folder: Path,
    say: Log,
    keeping: Keeping = Keeping(),
) -> List[TaskResult]:
    """Run every task, draw its pictures and write ``summary.yaml``.

    Args:
        tour_scene: checkpoints of the tour.
        obstacle_scene: the obstacle task.
        youbot_scene: the floor that the youBot clears.
        seed: see the option.
        folder: where results go.
        say: is told what is done, line by line.
        keeping: what is left beside summary and pictures.

    Raises:
        TourError: nothing of a scene can be reached.
        TrajectoryError: the tour cannot be timed.
        MissionError: the youBot cannot begin.
    """
    folder.mkdir(parents=True, exist_ok=True)
    begun = time.monotonic()

    def progress(text: str) -> None:
        say(f"[{time.monotonic() - begun:5.1f} s] {text}")

    progress(f"coursework, seed {seed}: inverse kinematics")
    results = [kinematics(seed)]
    progress(f"tour of {len(tour_scene.checkpoints)} checkpoints")
    tour = tours(tour_scene)
    pictures = [draw_tour(tour, tour_scene, folder / "tour.png")]
    files = [] if keeping.motion is None else [f"motion: {keeping.motion(tour.motion, folder)}"]
    if keeping.film is not None:
        title = f"tour of {len(tour_scene.checkpoints)} checkpoints"
        play_tour(tour_scene, tour.motion, keeping.film.arm(title, tour_scene))
    progress(
        f"{len(obstacle_scene.checkpoints)} checkpoints among {len(obstacle_scene.obstacles)} obstacles, in physics"
    )
    among = obstacles(obstacle_scene, seed, keeping.among)
    pictures.append(draw_obstacles(among, folder / "obstacles.png"))
    progress("the cell's floor")
    floor = floors()
    pictures.append(draw_coverage(floor, folder / "coverage.png"))
    progress(f"the youBot clears {len(youbot_scene.debris)} pieces from its floor, in physics")
    cleared = clearing(youbot_scene, seed, say, keeping.film or unwatched)
    if keeping.film is not None:
        files.append(f"film: {keeping.film.write(folder)}")
    pictures.append(draw_clearing(cleared, folder / "clearing.png"))
    results += [tour.task, among.task, floor.task, cleared.task]
    _tell(results, seed, [*(f"picture: {picture}" for picture in pictures), *files], say)
    _summarise(results, seed, folder)
    return results


def _tell(results: Sequence[TaskResult], seed: int, files: Sequence[str], say: Log) -> None:
    """Say every task's table, what was wrong, and where the files are."""
    for result in results:
        say(f"\n{result.title}")
        say(text_table(result.header, result.rows))
    faults = _faults(results)
    say(f"\ncoursework, seed {seed}: {'FAILED' if faults else 'SUCCESS'}")
    for fault in faults:
        say(f"  wrong: {fault}")
    for file in files:
        say(file)


def _faults(results: Sequence[TaskResult]) -> List[str]:
    return [f"{result.title}: {fault}" for result in results for fault in result.faults]


def _summarise(results: Sequence[TaskResult], seed: int, folder: Path) -> None:
    faults = _faults(results)
    summary = {
        "success": not faults,
        "seed": seed,
        "faults": faults,
        "tasks": {result.title: [dict(zip(result.header, row)) for row in result.rows] for result in results},
    }
    (folder / "summary.yaml").write_text(yaml.safe_dump(summary, sort_keys=False), encoding="utf-8")
