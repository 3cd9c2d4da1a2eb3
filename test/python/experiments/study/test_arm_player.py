"""The manipulator of the kinematic world against the sander's own kinematics, and its way to pause."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.control.arm.model import ArmDescription, ArmKinematics, load_arm
from yarm.control.sander.params import SanderParams
from yarm.control.sander.raster import coverage
from yarm.experiments.study.arm_plan import plan_track
from yarm.experiments.study.arm_player import LIFT_S, STOP_S, ArmModel, ArmPlayer, ArmTrack

STEP_S = 1.0 / 60.0


@pytest.fixture(scope="module", name="arm")
def _arm() -> ArmDescription:
    return load_arm()


def model_of(arm: ArmDescription) -> ArmModel:
    base = np.eye(4)
    base[:3, 3] = arm.base_xyz
    return ArmModel(arm.model, base, "sander_tip")


def test_its_tip_is_where_the_sander_thinks_it_is(arm: ArmDescription) -> None:
    model, kinematics = model_of(arm), ArmKinematics(arm)
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        assert model.tip(q) == pytest.approx(kinematics.tip(q)[:3, 3], abs=1e-9)


def test_its_points_cover_it_from_the_base_to_the_tip(arm: ArmDescription) -> None:
    points = model_of(arm).points(arm.storage)
    assert len(points) > 1000
    tip = np.array(model_of(arm).tip(arm.storage))
    assert np.linalg.norm(points - tip, axis=1).min() < 0.03
    assert points[:, 2].min() == pytest.approx(0.70, abs=0.01)


def player(arm: ArmDescription, phase_s: float = 0.0) -> ArmPlayer:
    work = np.outer(np.linspace(0.0, 1.0, 101), np.ones(6))
    return ArmPlayer(model_of(arm), ArmTrack(0.1, work, work + 5.0), phase_s)


def run(arm: ArmPlayer, span_s: float, enabled: bool) -> None:
    for _ in range(round(span_s / STEP_S)):
        arm.step(STEP_S, enabled)


def test_it_works_pauses_lifts_and_goes_on_where_it_stopped(arm: ArmDescription) -> None:
    at_work = player(arm, phase_s=2.0)
    run(at_work, 1.0, True)
    assert at_work.joints() == pytest.approx(np.full(6, 0.30), abs=0.011)
    run(at_work, STOP_S, False)
    stopped = at_work.joints()
    assert stopped == pytest.approx(np.full(6, 0.33), abs=0.011)
    run(at_work, LIFT_S + 1.0, False)
    assert at_work.joints() == pytest.approx(stopped + 5.0, abs=0.011)
    run(at_work, LIFT_S, True)
    assert at_work.joints() == pytest.approx(stopped, abs=0.05)
    run(at_work, 1.0, True)
    assert at_work.joints() == pytest.approx(stopped + 0.1, abs=0.03)


def test_it_starts_again_at_the_end(arm: ArmDescription) -> None:
    at_work = player(arm, phase_s=9.95)
    run(at_work, 1.05, True)
    assert at_work.joints() == pytest.approx(np.full(6, 0.10), abs=0.011)


def test_the_real_raster_covers_the_part_on_its_surface_and_hovers_above_it(arm: ArmDescription) -> None:
    track, model = plan_track(arm, SanderParams()), model_of(arm)
    tips = np.array([model.tip(q) for q in track.work[::5]])
    assert tips[:, 2] == pytest.approx(np.full(len(tips), 0.73), abs=0.003)
    assert coverage(tips, (-0.45, -0.30), (-0.05, 0.30), 0.73, 0.06) > 0.97
    hovers = np.array([model.tip(q) for q in track.hover[::5]])
    assert hovers[:, :2] == pytest.approx(tips[:, :2], abs=0.01)
    assert hovers[:, 2].min() > 1.15
    assert 60.0 < track.length_s < 120.0
