"""What each script does, step by step, with a planner that only names what it was asked for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, List, Tuple

import numpy as np
import pytest

from yarm.control.sander.progress import RasterProgress
from yarm.control.sander.scripts import SanderScripts, Situation
from yarm.control.sander.states import SanderState
from yarm.control.sander.steps import Compute, Follow, Script, Wait

LENGTH_M = 2.0
PLAN = SimpleNamespace(raster=SimpleNamespace(length_m=LENGTH_M), apart_m=lambda one, other: abs(one - other))


class NamingPlanner:
    """Motions are names; each stroke is a metre of the raster."""

    def __getattr__(self, name: str) -> Any:
        return lambda *_: name

    def raster(self, points: np.ndarray) -> Any:
        assert len(points) == 5
        return PLAN

    def stroke_from(self, plan: Any, arc_m: float, end_m: float) -> Any:
        assert plan is PLAN
        return SimpleNamespace(name=f"stroke {arc_m:.1f}", arc_m=np.array([arc_m, min(np.floor(arc_m) + 1.0, end_m)]))


def bench() -> Tuple[Situation, SanderScripts, List[str]]:
    hovered: List[str] = []
    situation = Situation(np.zeros(6))
    planner: Any = NamingPlanner()
    return (
        situation,
        SanderScripts(situation, planner, lambda: np.zeros((5, 3)), lambda: hovered.append("yes")),
        hovered,
    )


def play(script: Script, situation: Situation, pause_at: str = "") -> List[str]:
    """The motions followed, in order; at ``pause_at`` the sander is switched off in mid-motion, then on again."""
    log: List[str] = []
    answer: Any = None
    try:
        while True:
            step = script.send(answer)
            answer = True
            if isinstance(step, Compute):
                answer = step.function()
            elif isinstance(step, Wait):
                log.append("wait")
                situation.enabled = True
                assert step.until()
            elif isinstance(step, Follow):
                name = str(getattr(step.motion, "name", step.motion))
                log.append(name)
                if name == pause_at:
                    pause_at, situation.enabled = "", False
                    assert step.until()
                    answer = False
                    if step.note is not None:
                        step.note(float(step.motion.arc_m[0]) + 0.5)
    except StopIteration:
        return log


def test_scan_sweeps_hovers_and_hands_over() -> None:
    situation, scripts, hovered = bench()
    assert play(scripts.scan(), situation) == ["to_scan", "sweep", "to_hover"]
    assert hovered == ["yes"]
    assert situation.state is SanderState.TELEOPERATION
    assert not situation.scanning


def test_clouds_are_wanted_during_the_sweep_alone() -> None:
    situation, scripts, _ = bench()
    wanted = {}
    script = scripts.scan()
    step = next(script)
    while situation.state is SanderState.SCANNING:
        if isinstance(step, Follow):
            wanted[str(step.motion)] = situation.scanning
        step = script.send(step.function() if isinstance(step, Compute) else True)
    assert wanted == {"to_scan": False, "sweep": True}


@pytest.mark.parametrize(
    ("state", "motions"),
    [(SanderState.TELEOPERATION, ["to_storage"]), (SanderState.SCAN_TO_PATH, ["lift", "to_storage"])],
)
def test_store_lifts_only_off_the_raster(state: SanderState, motions: List[str]) -> None:
    situation, scripts, _ = bench()
    situation.state, situation.progress.share = state, 0.5
    assert play(scripts.store(), situation) == motions
    assert situation.state is SanderState.STORAGE
    assert situation.progress.share == 0.0


def test_sand_does_every_stroke_and_ends_lifted() -> None:
    situation, scripts, _ = bench()
    assert play(scripts.sand(), situation) == ["lift", "wait", "come_down", "stroke 0.0", "stroke 1.0", "lift"]
    assert situation.progress.share == 1.0
    assert situation.lifted


def test_a_pause_lifts_and_goes_on_where_it_stopped() -> None:
    situation, scripts, _ = bench()
    log = play(scripts.sand(), situation, pause_at="stroke 0.0")
    assert log == [
        "lift",
        "wait",
        "come_down",
        "stroke 0.0",
        "lift",
        "wait",
        "come_down",
        "stroke 0.5",
        "stroke 1.0",
        "lift",
    ]


def test_resume_keeps_the_plan_and_the_way() -> None:
    situation, scripts, _ = bench()
    plan: Any = PLAN
    situation.progress.begin(plan)
    situation.progress.note(1.0)
    assert play(scripts.resume(), situation) == ["lift", "wait", "come_down", "stroke 1.0", "lift"]


def test_progress_never_goes_back_and_needs_a_plan() -> None:
    progress = RasterProgress()
    progress.note(1.0)
    assert (progress.share, progress.finished) == (0.0, False)
    plan: Any = PLAN
    progress.begin(plan)
    progress.note(0.5)
    progress.note(0.3)
    assert (progress.arc_m, progress.share, progress.finished) == (0.5, 0.25, False)
    progress.note(LENGTH_M - 5e-4)
    assert progress.finished
