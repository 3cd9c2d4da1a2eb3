"""The physical cell: standing, driving, turning, braking, touching, slipping, repeating."""

from __future__ import annotations

import hashlib
import math
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np
import pybullet
import pytest

from yarm.geometry import transform_points
from yarm.geometry.kinds import ContactKind
from yarm.robots.ankurbot import CASTERS
from yarm.robots.hc10 import arm_mount
from yarm.sim.checks.cell_check import tip_joints
from yarm.sim.engine.world import TICK_S, SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.errors import CommandError
from yarm.sim.scenes.bodies import SpawnError
from yarm.sim.scenes.scene import Scene, load_scene, scene_from
from yarm.sim.scenes.specs import ThingSpec
from yarm.sim.sensors.camera_model import KINECT
from yarm.sim.sensors.cameras import Eyes

LIMIT = 5.0
ABOUT_CENTRE = np.radians([-45.0, 45.0, 45.0, -45.0])
FRONT, REAR = math.atan2(1.15, 0.15), math.atan2(1.45, 0.15)
ABOUT_EE = np.array([FRONT, -FRONT, REAR, -REAR])


def one_robot(x: float = 0.0, y: float = 0.0, heading_deg: float = 0.0, **more: Any) -> Scene:
    robot = {"name": "ankurbot_1", "type": "ankurbot", "x": x, "y": y, "heading_deg": heading_deg}
    return scene_from({"name": "test", "fixtures": [], "robots": [robot], **more}, "test")


def pose(world: SimWorld, frame: str) -> Tuple[np.ndarray, float]:
    matrix = world.transforms()[frame]
    return matrix[:3, 3].copy(), math.atan2(matrix[1, 0], matrix[0, 0])


def steer(world: SimWorld, robot: Ankurbot, angles: np.ndarray) -> None:
    for caster, angle in zip(CASTERS, angles):
        robot.steer(caster, float(angle))
    world.run(1.0)


@pytest.fixture
def driven() -> Iterator[Tuple[SimWorld, Ankurbot]]:
    with SimWorld(one_robot(-1.0, -1.0)) as world:
        world.run(0.2)
        yield world, world.robots["ankurbot_1"]


def test_everything_stands_still_for_a_minute() -> None:
    with SimWorld(load_scene("2m1ma")) as world:
        world.spawn(ThingSpec("debris_1", "Debris", -0.15, 0.2, 0.75, 0.3))
        world.run(1.0)
        before = {frame: matrix.copy() for frame, matrix in world.transforms().items()}
        world.run(60.0)
        for frame, matrix in world.transforms().items():
            assert np.linalg.norm(matrix[:3, 3] - before[frame][:3, 3]) < 0.002, frame
        assert world.failures() == []


def test_straight_translation_at_an_angle(driven: Tuple[SimWorld, Ankurbot]) -> None:
    world, robot = driven
    angle = math.radians(63.0)
    steer(world, robot, np.full(4, angle))
    start, yaw = pose(world, "ankurbot_1/base_link")
    robot.drive(1.0, 0.0, LIMIT)
    worst, done = 0.0, 0.0
    while done < 2.0:
        world.tick()
        moved = pose(world, "ankurbot_1/base_link")[0] - start
        done = float(moved[0] * math.cos(angle) + moved[1] * math.sin(angle))
        worst = max(worst, abs(float(moved[1] * math.cos(angle) - moved[0] * math.sin(angle))))
    assert worst < 0.03
    assert abs(pose(world, "ankurbot_1/base_link")[1] - yaw) < math.radians(1.0)


@pytest.mark.parametrize(("angles", "frame"), [(ABOUT_CENTRE, "base_link"), (ABOUT_EE, "ee")])
def test_turning_keeps_its_centre(driven: Tuple[SimWorld, Ankurbot], angles: np.ndarray, frame: str) -> None:
    world, robot = driven
    steer(world, robot, angles)
    centre = pose(world, f"ankurbot_1/{frame}")[0]
    robot.drive(0.0, 0.6, LIMIT)
    worst, turned = 0.0, 0.0
    while turned < math.radians(90.0):
        world.tick()
        point, turned = pose(world, f"ankurbot_1/{frame}")[0], pose(world, "ankurbot_1/base_link")[1]
        worst = max(worst, float(np.linalg.norm(point - centre)))
        assert world.time_s < 20.0
    assert worst < 0.03


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, math.pi / 4])
def test_braking_from_full_speed_lifts_no_wheel(angle: float) -> None:
    with SimWorld(one_robot(-1.5, -1.5)) as world:
        robot = world.robots["ankurbot_1"]
        steer(world, robot, np.full(4, angle))
        robot.drive(1.0, 0.0, LIMIT)
        world.run(0.8)
        robot.drive(0.0, 0.0, LIMIT)
        stopped, lifted, before = None, 0, pose(world, "ankurbot_1/base_link")[0]
        for i in range(round(1.0 / TICK_S)):
            world.contacts.take()
            world.tick()
            down = {side.link for c in world.contacts.take() for side in (c.a, c.b) if side.link.endswith("wheel")}
            lifted = max(lifted, 4 - len(down))
            now = pose(world, "ankurbot_1/base_link")[0]
            if stopped is None and np.linalg.norm(now - before) / TICK_S < 0.01:
                stopped = (i + 1) * TICK_S
            before = now
            tilt = world.transforms()["ankurbot_1/base_link"][2, 2]
            assert tilt > math.cos(math.radians(1.5))
        assert stopped is not None and stopped < 0.5
        assert lifted == 0


def test_commands_are_clamped_or_refused(driven: Tuple[SimWorld, Ankurbot]) -> None:
    _, robot = driven
    assert robot.steer("fl", 4.0) is True
    assert robot.caster_readings()[0].set_point == pytest.approx(math.pi)
    assert robot.steer("fl", 1.0) is False
    with pytest.raises(CommandError, match="caster fl: angle nan"):
        robot.steer("fl", float("nan"))
    assert robot.drive(9.0, 0.0, LIMIT) is True
    with pytest.raises(CommandError, match="yaw rate inf"):
        robot.drive(0.0, float("inf"), LIMIT)


def test_a_yaw_rate_without_a_centre_is_reported(driven: Tuple[SimWorld, Ankurbot]) -> None:
    world, robot = driven
    robot.drive(0.0, 1.0, LIMIT)
    assert world.tick() == ["ankurbot_1"]


def test_driving_into_a_box_is_a_failure_and_names_both() -> None:
    box = {"name": "box", "x": 1.2, "y": 0.0, "z": 0.3, "size": [0.3, 0.3, 0.6]}
    with SimWorld(one_robot(0.0, 0.0, obstacles=[box])) as world:
        world.robots["ankurbot_1"].drive(0.8, 0.0, LIMIT)
        touched: List[Any] = []
        clearances = []
        for _ in range(90):
            world.tick()
            touched += world.failures()
            clearances.append(world.clearances()[0])
        assert {touched[0].a.body, touched[0].b.body} == {"ankurbot_1", "box"}
        assert touched[0].kind is ContactKind.FAILURE
        assert clearances[0].distance_m > 0.2
        near = min((c for c in clearances if c.nearest), key=lambda c: c.distance_m)
        assert near.nearest == "box" and near.distance_m < 0.001


def test_clearance_is_the_distance_of_the_surfaces() -> None:
    box = {"name": "box", "x": 0.9, "y": 0.0, "z": 0.3, "size": [0.4, 0.4, 0.6]}
    with SimWorld(one_robot(0.0, 0.0, obstacles=[box])) as world:
        world.tick()
        reading = world.clearances()[0]
        assert reading.nearest == "box"
        assert reading.distance_m == pytest.approx(0.25, abs=0.01)  # arm's underside 0.85 over the box's top 0.60


def test_a_tucked_arm_is_furniture() -> None:
    with SimWorld(load_scene("3m")) as world:
        body = world.bodies["hc10_barc"]
        assert (body.kind, body.dynamic, world.arms) == ("Obstacle", False, {})
        before = world.transforms()["hc10_barc/sander_tip"].copy()
        world.run(5.0)
        assert np.linalg.norm(world.transforms()["hc10_barc/sander_tip"][:3, 3] - before[:3, 3]) < 0.002
        assert world.failures() == []
        assert {reading.robot for reading in world.clearances()} == {"ankurbot_1", "ankurbot_2", "ankurbot_3"}


def test_the_arm_follows_a_path_within_limits() -> None:
    with SimWorld(load_scene("1m1ma")) as world:
        arm = world.arms["hc10_barc"]
        goal = arm.path.position + np.array([0.5, 0.3, -0.4, 0.2, 0.6, 0.1])
        names = list(reversed(arm.joint_names))
        assert arm.follow(names, [list(reversed(goal))], [2.0]) == []
        world.run(1.0)
        half = np.array(arm.joint_readings()[1])
        world.run(1.5)
        end = np.array(arm.joint_readings()[1])
        assert end == pytest.approx(goal, abs=0.002)
        assert np.all(np.abs(goal - half) > 0.03)
        assert world.failures() == []
        with pytest.raises(CommandError, match="joint_1_s"):
            arm.follow(["a"], [[0.0]], [1.0])


def test_spawn_and_delete_and_their_refusals() -> None:
    with SimWorld(load_scene("1m1ma")) as world:
        world.spawn(ThingSpec("debris_9", "Debris", -0.2, 0.0, 0.75))
        assert "debris_9" in world.transforms()
        for spec, words in (
            (ThingSpec("debris_9", "Debris", 0.2, 0.0, 0.72), "'debris_9' is taken"),
            (ThingSpec("floor", "Target", 0.2, 0.0, 0.72), "'floor' is taken"),
            (ThingSpec("box", "Obstacle", 1.95, 1.6, 0.3, 0.0, (0.2, 0.2, 0.2)), "inside ankurbot_1"),
            (ThingSpec("debris_8", "Debris", -0.2, 0.0, 0.60), "inside table"),
        ):
            with pytest.raises(SpawnError, match=words):
                world.spawn(spec)
            assert spec.name == "debris_9" or spec.name not in world.bodies
        world.delete("debris_9")
        assert "debris_9" not in world.transforms()
        for name, words in (("debris_9", "nobody of that name"), ("table", "stays"), ("ankurbot_1", "stays")):
            with pytest.raises(SpawnError, match=words):
                world.delete(name)
        world.run(0.1)


def test_debris_that_perception_named_is_the_unregistered_piece_nearest_to_its_place() -> None:
    world = SimWorld(one_robot(x=1.5, fixtures=["table"]))
    for name, x, registered in (("loose_1", 0.10, False), ("loose_2", 0.34, False), ("debris_1", 0.22, True)):
        world.spawn(ThingSpec(name, "Debris", x, 0.3, 0.725, math.pi / 2, (), registered))
    assert world.named("debris_auto_7", (0.21, 0.3)) == "loose_1"
    assert world.named("debris_auto_7", (0.24, 0.3)) == "loose_2"
    assert world.named("debris_auto_7", (0.3, 0.61)) == "debris_auto_7", "too far from all"
    assert world.named("debris_1", (0.1, 0.3)) == "debris_1"
    world.delete(world.named("debris_auto_7", (0.1, 0.3)))
    with pytest.raises(SpawnError, match="debris_auto_9"):
        world.delete(world.named("debris_auto_9", (0.0, -0.5)))
    assert "loose_1" not in world.bodies and "loose_2" in world.bodies
    world.close()


def test_a_push_slips_the_debris_by_so_much() -> None:
    with SimWorld(load_scene("1m1ma")) as world:
        world.spawn(ThingSpec("debris_1", "Debris", -0.25, 0.0, 0.75))
        world.run(0.3)
        before = world.transforms()["debris_1"][:3, 3].copy()
        assert world.push("debris_1", 0.06, -0.08)
        assert not world.push("nobody", 0.1, 0.0)
        world.run(2.0)
        moved = world.transforms()["debris_1"][:3, 3] - before
        assert moved == pytest.approx([0.06, -0.08, 0.0], abs=0.012)


def test_an_unregistered_obstacle_walks_at_its_speed_and_the_cameras_see_it_where_it_is() -> None:
    with SimWorld(load_scene("single")) as world:
        world.spawn(ThingSpec("person", "Obstacle", -1.0, 0.0, 0.6, 0.0, (0.4, 0.4, 1.2), registered=False))
        world.spawn(ThingSpec("box", "Obstacle", -2.0, 0.0, 0.1, 0.0, (0.2, 0.2, 0.2)))
        assert not world.walk("box", 1.0, 0.0, 1.0)
        assert not world.walk("table", 1.0, 0.0, 1.0)
        assert not world.walk("nobody", 1.0, 0.0, 1.0)
        assert world.walk("person", 0.0, 1.5, 1.0)
        before = world.transforms()["person"][:3, 3].copy()
        world.run(1.0)
        assert world.transforms()["person"][:3, 3] - before == pytest.approx([0.0, 1.0, 0.0], abs=0.006)
        eyes = Eyes(1, noise=False)
        eyes.look_at(world.bodies, world.transforms())
        world.run(1.0)
        assert world.transforms()["person"][:3, 3] - before == pytest.approx([0.0, 1.5, 0.0], abs=1e-6)
        image = eyes.overhead_image(4, world.transforms())
        points = (KINECT.directions() * image.depth[..., None]) @ eyes.overhead_poses[3][:3, :3].T
        points = (points + eyes.overhead_poses[3][:3, 3]).reshape(-1, 3)
        high = points[(points[:, 2] > 0.9) & (points[:, 2] < 1.25) & (np.abs(points[:, 0] + 1.0) < 0.25)]
        assert len(high) > 50
        assert high[:, 1].min() >= 1.25 and high[:, 1].max() <= 1.75
        world.delete("person")
        assert "person" not in world.transforms()


def test_a_bin_is_moved_with_what_lies_in_it_and_the_truth_goes_along() -> None:
    with SimWorld(load_scene("1m1ma_bin")) as world:
        world.spawn(ThingSpec("debris_1", "Debris", 0.45, -1.45, 0.10))
        world.run(1.0)
        before = world.transforms()["bin_1"][:3, 3].copy()
        assert world.bin_of("debris_1") == "bin_1"
        assert world.walk("bin_1", 0.3, 0.0, 0.3)
        world.run(2.5)
        assert world.transforms()["bin_1"][:3, 3] - before == pytest.approx([0.3, 0.0, 0.0], abs=1e-6)
        assert world.transforms()["debris_1"][0, 3] > 0.45 + 0.1
        assert world.bin_of("debris_1") == "bin_1"
        world.spawn(ThingSpec("debris_2", "Debris", 0.38, -1.45, 0.05))
        world.run(1.0)
        assert world.bin_of("debris_2") == ""


def run_hash(seconds: float) -> str:
    """Hash of every pose of a busy second run: driving, turning, arm, debris pushed."""
    digest = hashlib.sha256()
    with SimWorld(load_scene("2m1ma")) as world:
        world.spawn(ThingSpec("debris_1", "Debris", -0.15, 0.2, 0.76, 0.3))
        first, second = world.robots["ankurbot_1"], world.robots["ankurbot_2"]
        for caster, angle in zip(CASTERS, ABOUT_CENTRE):
            second.steer(caster, float(angle))
        arm = world.arms["hc10_barc"]
        arm.follow(arm.joint_names, [arm.path.position + 0.3], [1.5])
        world.push("debris_1", 0.1, 0.0)
        for tick in range(round(seconds / TICK_S)):
            first.drive(0.5 * math.sin(0.1 * tick), 0.0, LIMIT)
            second.drive(0.0, 0.5 * math.cos(0.05 * tick), LIMIT)
            world.tick()
            for matrix in world.transforms().values():
                digest.update(matrix.tobytes())
    return digest.hexdigest()


def test_the_same_commands_give_the_same_bytes() -> None:
    assert run_hash(2.0) == run_hash(2.0)


def test_masses_and_centre_of_mass() -> None:
    with SimWorld(one_robot()) as world:
        uid = world.robots["ankurbot_1"].uid
        total, moment = 0.0, np.zeros(3)
        for index in range(-1, pybullet.getNumJoints(uid, physicsClientId=world.client)):
            mass = pybullet.getDynamicsInfo(uid, index, physicsClientId=world.client)[0]
            if index < 0:
                position = pybullet.getBasePositionAndOrientation(uid, physicsClientId=world.client)[0]
            else:
                position = pybullet.getLinkState(uid, index, physicsClientId=world.client)[0]
            total, moment = total + mass, moment + mass * np.array(position)
        assert total >= 40.0
        assert moment[2] / total < 0.20
        assert moment[:2] / total == pytest.approx([0.0, 0.0], abs=0.005)


def test_registered_solids_lie_where_the_engine_has_them() -> None:
    """The solids' bounds in world agree with PyBullet's own boxes around each body."""
    with SimWorld(load_scene("1m1ma")) as world:
        transforms: Dict[str, np.ndarray] = dict(world.transforms())
        for body in world.bodies.values():
            low, high = np.full(3, np.inf), np.full(3, -np.inf)
            for item in body.solids:
                matrix = transforms[item.frame] @ item.T_frame_solid
                reach = np.abs(matrix[:3, :3]) @ item.solid.half_extent
                low, high = np.minimum(low, matrix[:3, 3] - reach), np.maximum(high, matrix[:3, 3] + reach)
            boxes = [
                pybullet.getAABB(uid, index, physicsClientId=world.client)
                for uid in body.uids
                for index in range(-1, pybullet.getNumJoints(uid, physicsClientId=world.client))
                if pybullet.getCollisionShapeData(uid, index, physicsClientId=world.client)
            ]
            if boxes:
                assert low == pytest.approx(np.min([b[0] for b in boxes], axis=0), abs=0.03), body.name
                assert high == pytest.approx(np.max([b[1] for b in boxes], axis=0), abs=0.03), body.name


def test_the_sander_on_debris_is_counted_apart() -> None:
    with SimWorld(load_scene("1m1ma")) as world:
        arm = world.arms["hc10_barc"]
        joints = tip_joints(world.client, arm, -0.25, 0.0, 0.765)
        assert joints is not None
        arm.place(arm_mount().storage)
        world.spawn(ThingSpec("debris_1", "Debris", -0.25, 0.0, 0.75))
        arm.place(joints)
        world.contacts.take()
        world.run(0.5)
        kinds = {(c.a.link, c.b.link): c.kind for c in world.contacts.take() if "sander" in (c.a.link, c.b.link)}
        assert set(kinds.values()) == {ContactKind.SANDER_DEBRIS}


def test_two_arms_each_stand_on_and_sand_at_their_own_station() -> None:
    with SimWorld(load_scene("2m2ma")) as world:
        world.run(0.5)
        assert world.failures() == []
        assert sorted(reading.robot for reading in world.clearances()) == [*sorted(world.robots), *sorted(world.arms)]
        for name, arm in world.arms.items():
            own = world.contacts.stations[name]
            part = transform_points(arm.station.pose, [[-0.25, 0.0, 0.0]])[0]
            joints = tip_joints(world.client, arm, part[0], part[1], 0.7305)
            assert joints is not None, name
            arm.place(joints)
            tip = arm.transforms()[f"{name}/sander_tip"]
            assert tip[:3, 3] == pytest.approx([part[0], part[1], 0.7305], abs=0.005)
            assert tip[:3, 2] == pytest.approx([0.0, 0.0, -1.0], abs=0.01)
            assert {own["table"], own["stand"]} <= set(world.bodies)
            with pytest.raises(SpawnError, match="stays"):
                world.delete(own["table"])


def test_the_second_arm_moves_alone() -> None:
    with SimWorld(load_scene("2m2ma")) as world:
        first, second = world.arms["hc10_barc"], world.arms["hc10_barc_2"]
        before = first.joint_readings()[1]
        second.follow(second.joint_names, [second.path.position + 0.2], [1.0])
        world.run(1.5)
        assert np.array(first.joint_readings()[1]) == pytest.approx(before, abs=0.002)
        assert np.array(second.joint_readings()[1]) == pytest.approx(second.path.position, abs=0.002)
        assert np.max(np.abs(second.path.position - np.array(second.station.folded))) == pytest.approx(0.2, abs=1e-6)
