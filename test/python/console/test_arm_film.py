"""The film of the arm at its checkpoints: links, checkpoints and words are what the physics has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.films import shown
from yarm.console.arm_film import ARM, AROUND, FREE
from yarm.console.film import Film, unpack
from yarm.console.floor_film import FloorFilm
from yarm.console.reel import GAP_S, HAND, PERIOD_S
from yarm.console.wire import decode
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.kinematics.forward import forward
from yarm.manipulation.motion.checkpoints import ArmScene, Checkpoint, Obstacle
from yarm.manipulation.motion.trajectory import arm_limits, quintic
from yarm.manipulation.obstacles.physics import ArmWorld

START, MIDDLE, END = np.array([0.0, 0.3, 0.8, 0.6, 0.0]), np.array([0.5, 0.2, 0.9, 0.7, 0.0]), np.zeros(5)
NEAR_M = 0.001
SCENE = ArmScene("test", START, (Checkpoint("near", forward(MIDDLE)), Checkpoint("up", forward(END))), ())


def in_the_way() -> ArmScene:
    """The same with a ball about where the hand goes first."""
    return replace(SCENE, obstacles=(Obstacle("ball", Solid(Shape.SPHERE, (0.06,), forward(MIDDLE))),))


@pytest.fixture(name="taken")
def taken_fixture(tmp_path):
    """Two tasks in one film, as it is read back; where links and hand were at the end of the first."""
    film, motions = FloorFilm("arm"), [quintic(START, MIDDLE, arm_limits()), quintic(MIDDLE, END, arm_limits())]
    with ArmWorld(SCENE) as world:
        take = film.arm("free", SCENE)
        world.play(motions, take)
        film.reel._next_s = 0.0
        take(world)
        last = world.link_frames(), world.hand_pose()[:3, 3], world.time_s
    with ArmWorld(in_the_way(), solid=False) as world:
        world.play(motions[:1], film.arm("through a ball", in_the_way()))
    read = Film.read(film.write(tmp_path))
    messages = [decode(message) for i in range(len(read.index()["blocks"])) for _, message in unpack(read.block(i))]
    return read, messages, last


def of_task(messages, words):
    """The pictures of a task, and the messages that came before the last of them."""
    last = max(i for i, (header, _) in enumerate(messages) if header.get("room", {}).get("title", "").endswith(words))
    states = [found for found in messages if found[0].get("room", {}).get("title", "").endswith(words)]
    return states, {header["kind"]: (header, arrays) for header, arrays in messages[: last + 1]}


def test_links_are_where_the_physics_has_them_and_the_page_looks_at_them(taken):
    _, messages, (links, hand, _) = taken
    states, newest = of_task(messages, "free")
    scene = newest["scene"][0]
    assert scene["around"] == list(AROUND)
    assert [body["name"] for body in scene["bodies"]] == [ARM]
    poses = dict(zip(scene["frames"], states[-1][1]["poses"]))
    assert set(poses) >= {f"arm_link_{n}" for n in range(6)}
    for name, pose in poses.items():
        np.testing.assert_allclose(pose, links[name], atol=1e-5)
    first, ways = 0, {}
    for line in states[-1][0]["lines"]:
        ways[line["layer"], line["name"]] = states[-1][1]["points"][first : first + line["count"]]
        first += line["count"]
    assert np.linalg.norm(ways["path", HAND][-1] - forward(END)[:3, 3]) < NEAR_M
    assert np.linalg.norm(ways["driven", HAND] - hand, axis=1).min() < 0.02
    assert np.linalg.norm(ways["driven", HAND][0] - forward(START)[:3, 3]) < 0.02


def test_checkpoints_are_marked_and_ticked_when_the_hand_has_been_there(taken):
    read, messages, _ = taken
    states, newest = of_task(messages, "free")
    marks, arrays = newest["marks"]
    assert [text["text"] for text in marks["texts"]] == ["near \u2713", "up \u2713"]
    np.testing.assert_allclose(arrays["pose"].reshape(-1, 4, 4)[0], forward(MIDDLE), atol=1e-5)
    np.testing.assert_allclose(arrays["points"][1], forward(MIDDLE)[:3, 3], atol=1e-5)
    assert states[0][0]["room"]["facts"][0] == ["reached", "0 of 2 checkpoints"]
    assert states[-1][0]["room"]["facts"][:3] == [
        ["reached", "2 of 2 checkpoints"],
        ["nearest", "up, 0.000 m away"],
        ["touches", FREE],
    ]
    texts = [event["text"] for event in read.index()["events"]]
    assert texts[:4] == ["free", "the hand is at near", "the hand is at up", "through a ball"]


def test_the_next_task_has_its_own_drawings_and_marks_and_follows_in_time(taken):
    read, messages, (_, _, ended_s) = taken
    states, newest = of_task(messages, "through a ball")
    assert [body["name"] for body in newest["scene"][0]["bodies"]] == [ARM, "ball"]
    assert len(newest["marks"][0]["texts"]) == 2
    assert any("and ball" in event["text"] for event in read.index()["events"])
    assert any("and ball" in header["room"]["facts"][2][1] for header, _ in states)
    times = [time_s for block in shown(read) for time_s, header in block if header["kind"] == "state"]
    assert sorted(times) == times
    assert states[0][0]["time_s"] == pytest.approx(ended_s + GAP_S, abs=2 * PERIOD_S)
