"""Parameters of the node ``run_experiment``."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.commander.params import Removal
from yarm.params import param


@dataclass(frozen=True)
class ExperimentParams:
    """One experiment: what to run, how long to wait, where to write."""

    case: str = param("1m1ma", "", "name of the experiment, for its limits and for the results' folder")
    seed: int = param(3, "", "seed of the layout, the noise and the planner; names the results' folder", 0, 2**31 - 1)
    vary: bool = param(True, "", "the simulation runs the seed's layout; false: the scene file's")
    mode: str = param("boundless", "", "mode of the Commander", choices=("bounded", "boundless"))
    sync: bool = param(
        False, "", "lock-step: time stands still while the mission is driven, so that it repeats exactly"
    )
    removal: str = param(
        Removal.DELETE.value,
        "",
        "what the Commander does with debris: with bin it must end in one by ground truth",
        choices=[way.value for way in Removal],
    )
    sand_elsewhere: bool = param(
        False, "", "manipulators sand elsewhere rather than pause, so that no pause is demanded of them"
    )
    cleanup: bool = param(False, "", "send everybody home at the end")
    results: str = param("results", "", "folder that holds <case>/<seed>/; made when missing")
    limit_s: float = param(0.0, "s", "simulated time the mission may take; 0 for the case's own limit", 0.0, 36000.0)
    raster: float = param(0.0, "", "the mission begins when so much of the manipulator's raster is done", 0.0, 1.0)
    start_limit_s: float = param(120.0, "s", "wall time until every node must have answered", 1.0, 3600.0)
    calibration_limit_s: float = param(240.0, "s", "simulated time the calibration may take", 1.0, 3600.0)
    cleanup_limit_s: float = param(180.0, "s", "simulated time the way home may take", 1.0, 3600.0)
    stall_limit_s: float = param(60.0, "s", "wall time simulated time may stand still", 1.0, 3600.0)
    arrival_limit_m: float = param(
        0.12, "m", "an end effector this near its goal has arrived (ground truth)", 0.01, 1.0
    )
    path_period_s: float = param(0.05, "s", "simulated time between two recorded poses of a robot", 0.01, 10.0)
    film_hz: float = param(
        5.0, "Hz", "pictures a second of simulated time in run.film, which the console plays; 0: no film", 0.0, 30.0
    )
    plots: bool = param(True, "", "draw the pictures")
    replay: str = param("", "", "folder of a run to be repeated up to one of its decisions; empty: none")
    replay_decision: int = param(0, "", "number of that decision; there time stands still", 0, 10**9)
    replay_hold: bool = param(True, "", "stay there until the node is ended; false: end there")
    soak_s: float = param(0.0, "s", "soak: go on with random debris for so much simulated time; 0: no soak", 0.0, 1e6)
    memory_limit_mb: float = param(30.0, "MB", "soak: no process may grow by more in its second half", 1.0, 10000.0)


@dataclass(frozen=True)
class KeeperParams:
    """What is known of the cell beforehand, and where to write."""

    scene: str = param("1m1ma_bin", "", "the scene that runs: its parts are kept account of, square by square")
    seed: int = param(-1, "", "seed of its layout; -1 for the scene's own", -1, 2**31 - 1)
    vary: bool = param(True, "", "the simulation runs the seed's layout; false: the scene file's")
    removal: str = param(
        Removal.DELETE.value,
        "",
        "what the Commander does with debris: with bin it must end in one by ground truth",
        choices=[way.value for way in Removal],
    )
    results: str = param("results", "", "folder that holds by_hand/<scene>/<when>/; made when missing")
    arrival_limit_m: float = param(
        0.12, "m", "an end effector this near its goal has arrived (ground truth)", 0.01, 1.0
    )
    plots: bool = param(True, "", "draw the pictures")
