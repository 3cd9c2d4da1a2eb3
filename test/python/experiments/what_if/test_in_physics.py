"""What if, in physics: any cell becomes a scene that the simulator reads, with the settings that it has."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from concurrent.futures import wait
from dataclasses import replace
from pathlib import Path
from typing import Callable

import numpy as np
import pytest
import yaml

from yarm.commander.params import CommanderParams
from yarm.experiments.what_if import physics
from yarm.experiments.what_if.ask import alternative, specs_of
from yarm.experiments.what_if.cell import TUCKED, Cell, Placed, WhatIfError, cell_of, cell_of_case
from yarm.experiments.what_if.live import cell_of_map
from yarm.experiments.what_if.physics import check_physics, runs_at_once, scene_of_cell, with_robots
from yarm.experiments.what_if.trial import WhatIfSpec
from yarm.experiments.what_if.world import Fork
from yarm.robots.hc10 import AT_ORIGIN, NAME
from yarm.sim.scenes.scene import Scene, load_scene, scene_from
from yarm.sim.scenes.scene_file import scene_text

LIMITS = {"bounded": False, "limit_s": 90.0}


def written(scene: Scene) -> Scene:
    return scene_from(yaml.safe_load(scene_text(scene)), "written")


@pytest.mark.parametrize("name", ["1m1ma", "2m1ma_bin", "2m2ma", "3m6_bin", "single"])
def test_a_cell_is_the_scene_that_it_was_made_of(name: str) -> None:
    """But for events, which have happened: what they bring is there."""
    scene = load_scene(name)
    again = written(scene_of_cell(cell_of(scene, name), 7))
    assert again.seed == 7 and again.events == ()
    for robot, then in zip(again.robots, scene.robots):
        assert (robot.name, robot.type) == (then.name, then.type)
        assert (robot.x, robot.y, math.cos(robot.heading_rad - then.heading_rad)) == pytest.approx((then.x, then.y, 1))
    assert [(arm.name, arm.tucked) for arm in again.arms] == [(arm.name, arm.tucked) for arm in scene.arms]
    for arm, arm_then in zip(again.arms, scene.arms):
        assert np.allclose(arm.station.pose, arm_then.station.pose, atol=1e-6)
        if arm.tucked:
            assert arm.station.folded == pytest.approx(arm_then.station.folded, abs=1e-6)
    assert [f.name for f in again.placed_fixtures] == [f.name for f in scene.placed_fixtures]
    places = {thing.name: (thing.kind, thing.x, thing.y) for thing in scene.all_things}
    assert {thing.name: (thing.kind, thing.x, thing.y) for thing in again.things} == places


def test_a_live_map_becomes_a_scene_its_arm_that_is_none_a_box() -> None:
    box = Placed("crate", "Obstacle", 1.5, 0.5, 0.25, 0.0, (0.3, 0.3, 0.5))
    stray = Placed("debris_auto_1", "Debris", -0.2, 0.1, 0.75)
    first = replace(cell_of_case("1m1ma_bin"), obstacles=(box,), goals=(stray,), scene="")
    fork = Fork(first, CommanderParams(), 0.3, np.random.default_rng(0))
    scene = written(scene_of_cell(cell_of_map(fork._map(), {NAME: AT_ORIGIN}), 1))
    assert [f.name for f in scene.placed_fixtures] == ["table", "stand", "bin_1"]
    assert {thing.name for thing in scene.things} == {"crate", "debris_auto_1"}
    (piece,) = [thing for thing in scene.things if thing.kind == "Debris"]
    assert not piece.registered and 0.74 < piece.z < 0.77 and scene.has_stray_debris
    away = replace(first, arms=(replace(first.arms[0], x=1.0, y=1.0),))
    named = {thing.name for thing in written(scene_of_cell(away, 1)).things}
    assert {"crate", "debris_auto_1"} < named, "the table at the origin is nobody's, and stays"
    assert {name for name in named if name.startswith("table")} == {"table_box_1", "table_box_2"}


def test_robots_are_taken_from_a_scene_or_added_and_its_events_know() -> None:
    scene = load_scene("2m1ma", 5)
    one, three = with_robots(scene, 1), with_robots(scene, 3)
    assert [robot.name for robot in one.robots] == ["ankurbot_1"] and len(three.robots) == 3
    assert three.robots[:2] == scene.robots, "who was there stands where he stood"
    for changed in (one, three):
        names = tuple(robot.name for robot in changed.robots)
        assert [e.when.robots for e in changed.events if e.when.robots] == [names] * 3
        assert written(changed).things == changed.things
    assert len(one.events) == len(scene.events)


@pytest.fixture(name="cell", scope="module")
def cell_fixture() -> Cell:
    return replace(cell_of_case("1m1ma"), scene="", settings=(("check_steps", "true"), ("turns_deg", "[0.0, -90.0]")))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("pause_distance_m=0.5", "pause_distance_m: settings are planner, .*robots"),
        ("robots=9", "must be within 1 to 4"),
        ("removal=bin", "the cell has no bins"),
    ],
)
def test_what_a_run_in_physics_does_not_know_is_refused(cell: Cell, settings: str, words: str) -> None:
    with pytest.raises(WhatIfError, match=words):
        check_physics(specs_of(cell, [alternative(""), alternative(settings)], 1, 1, LIMITS, in_physics=True))


def test_a_cell_that_is_no_scene_is_refused_with_what_is_wrong(cell: Cell) -> None:
    far = replace(cell, goals=(Placed("debris_1", "Debris", 9.0, 0.0, 0.75),))
    with pytest.raises(WhatIfError, match=r"--physics: scene 1m1ma: .*spawn.x = .*expected a number within"):
        check_physics(specs_of(far, [alternative("")], 1, 1, LIMITS, in_physics=True))
    unchecked = replace(cell, settings=(("check_steps", "report"),))
    with pytest.raises(WhatIfError, match="check_steps = 'report'"):
        check_physics(specs_of(unchecked, [alternative("")], 1, 1, LIMITS, in_physics=True))


def test_hidden_space_counts_where_there_are_cameras(cell: Cell) -> None:
    (spec,) = specs_of(cell, [alternative("hidden=known_bodies")], 1, 1, LIMITS, in_physics=True)
    options = physics._options(spec)
    assert "--hidden=known_bodies" in options and "--turns=0,-90" in options and "--removal=delete" in options
    with pytest.raises(WhatIfError, match="no cameras"):
        specs_of(cell, [alternative("hidden=known_bodies")], 1, 1, LIMITS)


def test_whether_it_sands_elsewhere_counts_where_the_sander_decides(cell: Cell) -> None:
    (spec,) = specs_of(cell, [alternative("sand_elsewhere=true")], 1, 1, LIMITS, in_physics=True)
    check_physics([spec])
    assert "--sand-elsewhere" in physics._options(spec)
    live = replace(cell, settings=(("sand_elsewhere", "True"),))
    own, other = specs_of(live, [alternative(""), alternative("sand_elsewhere=false")], 1, 1, LIMITS, in_physics=True)
    assert "--sand-elsewhere" in physics._options(own) and "--sand-elsewhere" not in physics._options(other)
    with pytest.raises(WhatIfError, match="a fork plays the raster back"):
        specs_of(cell, [alternative("sand_elsewhere=true")], 1, 1, LIMITS)


def test_debris_comes_when_the_raster_is_where_it_was(cell: Cell) -> None:
    """It would keep the sander waiting before; where no manipulator works it is there at once."""
    (spec,) = specs_of(replace(cell, share=0.4), [alternative("")], 1, 1, {**LIMITS, "bounded": True}, in_physics=True)
    scene = scene_from(yaml.safe_load(physics._case_of(spec)), "written")
    assert [(e.when.state, e.spawn and e.spawn.name) for e in scene.events] == [("BOUNDED", "debris_1")]
    assert not scene.things and physics._options(spec)[-6:][0] == "--raster" and "0.400" in physics._options(spec)
    folded = replace(cell, arms=tuple(replace(arm, kind=TUCKED) for arm in cell.arms))
    (spec,) = specs_of(folded, [alternative("")], 1, 1, LIMITS, in_physics=True)
    scene = scene_from(yaml.safe_load(physics._case_of(spec)), "written")
    assert not scene.events and [thing.name for thing in scene.things] == ["debris_1"]
    assert "0.000" in physics._options(spec)


def test_an_interrupt_ends_the_runs_that_go_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cell: Cell) -> None:
    """Each is told by the signal that run_experiment cleans up at, and waited for."""
    told = tmp_path / "told"
    code = (
        f"import signal,sys,time\nsignal.signal(signal.SIGINT, lambda *_: (open({str(told)!r}, 'w'), sys.exit(130)))\n"
    )
    code += f"open({str(tmp_path / 'up')!r}, 'w')\ntime.sleep(600)"
    monkeypatch.setattr(physics, "experiment_command", lambda: [sys.executable, "-c", code])
    (spec,) = specs_of(cell, [alternative("")], 1, 1, LIMITS, in_physics=True)
    with pytest.raises(KeyboardInterrupt), runs_at_once(2) as pool:
        work = pool.submit(physics.run_physics, spec)
        until((tmp_path / "up").exists)
        raise KeyboardInterrupt
    assert told.exists() and wait([work]).done and not physics.RUNS.going
    assert "exit code 130" in str(work.exception())


def test_after_an_interrupt_no_run_is_begun(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cell: Cell) -> None:
    """One that waits for its turn must not take it when the one before has been ended."""
    code = f"open({str(tmp_path / 'up')!r}, 'w')"
    monkeypatch.setattr(physics, "RUNS", physics.Runs())
    monkeypatch.setattr(physics, "experiment_command", lambda: [sys.executable, "-c", code])
    (spec,) = specs_of(cell, [alternative("")], 1, 1, LIMITS, in_physics=True)
    with pytest.raises(KeyboardInterrupt), runs_at_once(1):
        raise KeyboardInterrupt
    with pytest.raises(RuntimeError, match="interrupted before it began"):
        physics.run_physics(spec)
    assert not (tmp_path / "up").exists()


def test_a_run_ends_with_the_thread_that_has_started_it(tmp_path: Path) -> None:
    """As when the asking process is killed."""
    up = tmp_path / "up"
    inner = f"import os,time\nopen({str(up)!r}, 'w').write(str(os.getpid()))\ntime.sleep(600)"
    code = (
        "import sys\nfrom yarm.experiments.what_if import physics\n"
        f"physics.RUNS.to_the_end([sys.executable, '-c', {inner!r}])"
    )
    with subprocess.Popen([sys.executable, "-c", code]) as asking:
        until(lambda: up.exists() and up.read_text() != "")
        asking.send_signal(signal.SIGKILL)
    until(lambda: not Path(f"/proc/{up.read_text()}").exists())


def until(true: Callable[[], bool], limit_s: float = 60.0) -> None:
    """Wait, so long at most."""
    end = time.monotonic() + limit_s
    while not true():
        assert time.monotonic() < end, "in vain"
        time.sleep(0.05)


def test_the_same_spec_gives_the_same_scene(cell: Cell) -> None:
    spec = WhatIfSpec(cell, "as it is", (), 4)
    assert physics._case_of(spec) == physics._case_of(spec) != physics._case_of(replace(spec, seed=5))
