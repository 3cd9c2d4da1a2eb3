"""What the console makes of messages, without a master: bytes of /tf, statuses, plans, logs, addresses."""

from __future__ import annotations

import asyncio
import inspect
import io
import math
import re
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import psutil
import pytest
import rospy
from actionlib_msgs.msg import GoalStatusArray
from aiohttp import web
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from rospy.impl.tcpros import DEFAULT_BUFF_SIZE
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray
from yarm.msg import (
    CommanderStatus,
    GridIndex,
    GridIndexVector,
    MoveRobotActionGoal,
    MoveRobotActionResult,
    ObjectRegistry,
    PlanReport,
    RegisteredObject,
    SafetyStatus,
    TaskStatus,
)

from yarm.commander.states import STATE_DOCS, State
from yarm.console.params import ConsoleParams
from yarm.console.picture import BodyDrawing
from yarm.console.wire import decode
from yarm.geometry import GridSpec
from yarm.geometry.solids import Shape, Solid
from yarm.ros.common import names
from yarm.ros.console import links
from yarm.ros.console.cell_book import SENDERS
from yarm.ros.console.cell_words import commander_words, people_discs, safety_words, server_words, ways_ahead
from yarm.ros.console.events import MOST, EventLog
from yarm.ros.console.filmer import Filmer
from yarm.ros.console.node import address, serve
from yarm.ros.console.robots import RobotBook
from yarm.ros.console.routes import Feed, stamp_of
from yarm.ros.console.system_book import SystemBook
from yarm.ros.console.throttle import AGAIN_S, throttled
from yarm.ros.console.transforms import PoseBook, read_transforms
from yarm.ros.console.view import LiveView


def serialised(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def transform(parent, child, x):
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id = parent
    made.transform.translation.x, made.transform.rotation.w = x, 1.0
    return made


def test_the_bytes_of_tf_are_read_as_rospy_reads_them():
    data = serialised(TFMessage([transform("world", "/a", 1.5), transform("a", "b\u00e4r", -2.0)]))
    assert list(read_transforms(data)) == [
        ("world", "a", (1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
        ("a", "b\u00e4r", (-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)),
    ]


@pytest.mark.parametrize("cut", [0, 3, 20, 60])
def test_bytes_that_end_too_early_are_refused(cut):
    data = serialised(TFMessage([transform("world", "a", 1.5)]))
    with pytest.raises(ValueError, match="cannot be read"):
        list(read_transforms(data[:cut]))


def test_a_commander_that_was_not_heard_has_no_buttons():
    assert commander_words(None) == {"commander": None, "buttons": [], "tasks": []}
    assert commander_words(CommanderStatus(state=99)) == {"commander": None, "buttons": [], "tasks": []}


def test_a_commanders_status_becomes_words_buttons_and_tasks():
    task = TaskStatus(robot="r", goal="d", kind="Debris", status="moving", distance_left_m=math.nan)
    status = CommanderStatus(state=5, state_name="BOUNDLESS", busy=True, tasks=[task], elapsed_s=2.0)
    words = commander_words(status)
    assert words["commander"]["state"] == "BOUNDLESS"
    assert words["commander"]["means"] == STATE_DOCS[State.BOUNDLESS]
    assert [button["label"] for button in words["buttons"] if not button["refusal"]] == ["previous_state"]
    assert words["tasks"] == [
        {"robot": "r", "goal": "d", "kind": "Debris", "status": "moving", "reason": "", "left_m": None}
    ]


def test_a_safety_monitors_word_becomes_stop_and_rooms():
    said = SafetyStatus(
        robots=["a", "b"], clearance_m=[math.inf, 0.25], nearest=["", "table"], stopped=[False, True], latched=True
    )
    said.reason = "stopped by somebody"
    words = safety_words(said)
    assert words["stop"] == {"latched": True, "reason": "stopped by somebody"}
    assert words["robots"][0] == {"name": "a", "clearance_m": None, "nearest": "", "held": False}
    assert words["robots"][1]["clearance_m"] == 0.25
    assert safety_words(None) == {"stop": None, "robots": []}


def test_a_plan_becomes_ways_over_the_middles_of_its_columns():
    spec = GridSpec()
    path = GridIndexVector([GridIndex(0, 0, 0), GridIndex(10, 20, 0)])
    (way,) = ways_ahead(PlanReport(robots=["r"], paths=[path]), spec)
    wanted = np.asarray(spec.lower[:2]) + (np.array([[0.5, 0.5], [10.5, 20.5]])) * spec.resolution[:2]
    assert (way.layer, way.name) == ("path", "r")
    np.testing.assert_allclose(way.points[:, :2], wanted)


def test_discs_of_people_are_drawn_as_large_as_the_safety_monitor_says():
    disc = Marker(action=Marker.ADD, ns="people")
    disc.pose.position.x, disc.pose.position.y, disc.scale.x = 1.0, -0.5, 1.6
    gone, absurd = Marker(action=Marker.DELETE), Marker(action=Marker.ADD)
    absurd.scale.x = math.nan
    (line,) = people_discs(MarkerArray([gone, absurd, disc]))
    assert line.layer == "people"
    away_m = np.linalg.norm(line.points[:, :2] - (1.0, -0.5), axis=1)
    np.testing.assert_allclose(away_m, 0.8)
    assert people_discs(None) == []


def test_each_action_server_is_told_whether_it_answers():
    never = (-math.inf, -math.inf)
    heard = {"b": never, "a": (100.0, 50.0), "c": (90.0, 40.0), "slow": (90.0, 48.0)}
    said = {each["name"]: (each["level"], each["text"]) for each in server_words(heard, 101.0, 50.0)}
    assert list(said) == [f"action server of {name}" for name in ("a", "b", "c", "slow")]
    assert said["action server of a"] == said["action server of slow"] == ("ok", "answers")
    assert said["action server of b"] == ("stale", "not heard yet")
    assert said["action server of c"] == ("error", "silent for 10 s")


def test_a_cell_says_where_people_may_be_and_who_answers(heard):
    view, topics, clock = heard
    robot = RegisteredObject(name="ankurbot_1", object="Mobile", type="dynamic", seed_frame="a")
    topics[names.OBJECT_REGISTRY](ObjectRegistry(entries=[robot]))
    disc = Marker(action=Marker.ADD)
    disc.scale.x = 1.0
    topics[names.SAFETY_PEOPLE](MarkerArray([disc]))
    answer = rospy.AnyMsg()
    answer.deserialize(serialised(GoalStatusArray()))
    topics[f"{names.move_robot('ankurbot_1')}/status"](answer)

    def shown():
        header = decode(view.state())[0]
        return [line["layer"] for line in header["lines"]], [each["level"] for each in header["servers"]]

    assert shown() == (["people"], ["ok"])
    clock["wall"], clock["simulated"] = clock["wall"] + 9.0, clock["simulated"] + 9.0
    assert shown() == ([], ["error"]), "what is old is shown no more"


def test_a_move_that_was_released_is_drawn_with_what_it_sweeps():
    book = RobotBook()
    book.follow(["ankurbot_1"], [])
    routes, server = book.routes(), names.move_robot("ankurbot_1")
    goal = MoveRobotActionGoal()
    goal.goal_id.id, goal.goal.action = "7", "False"
    goal.goal.target.position.x = goal.goal.target.orientation.w = 1.0
    routes[f"{server}/goal"].take(goal)
    body = BodyDrawing(
        "ankurbot_1",
        "Mobile",
        "dynamic",
        "ankurbot_1/ee",
        [("ankurbot_1/base_link", Solid(Shape.BOX, (0.4, 0.2, 0.5), np.eye(4)))],
    )
    unturned = (0.0, 0.0, 0.0, 1.0)
    poses = {"ankurbot_1/ee": (0.0, 0.0, 0.8, *unturned), "ankurbot_1/base_link": (-0.8, 0.0, 0.0, *unturned)}
    way, outline = book.lines(poses, [body])
    assert way.points.tolist() == [[0.0, 0.0, 0.8], [1.0, 0.0, 0.8]]
    low, high = outline.points.min(axis=0), outline.points.max(axis=0)
    np.testing.assert_allclose([*low[:2], *high[:2]], [-1.0, -0.1, 0.4, 0.1], atol=1e-9)
    absurd = MoveRobotActionGoal()
    absurd.goal.target.position.x = math.nan
    routes[f"{server}/goal"].take(absurd)
    assert len(book.lines(poses, [body])) == 2, "a pose that is none changes nothing"
    done = MoveRobotActionResult()
    done.status.goal_id.id = "7"
    routes[f"{server}/result"].take(done)
    assert book.lines(poses, [body]) == []


def test_it_hears_and_calls_only_what_the_interface_names(heard):
    view, topics, _ = heard
    kinds = {"ankurbot_1": "Mobile", "hc10_barc": "Manipulator"}
    entries = [RegisteredObject(name=n, object=kind, type="dynamic", seed_frame=n) for n, kind in kinds.items()]
    topics[names.OBJECT_REGISTRY](ObjectRegistry(entries=entries))
    view.state()
    page = (Path(__file__).resolve().parents[2] / "docs" / "ros_api.md").read_text(encoding="utf-8")
    named = {re.sub(r"\{\w+\}", "*", name) for name in re.findall(r"^\| `([^`]+)`", page, re.M)}
    asked = {re.sub("ankurbot_1|hc10_barc", "*", topic) for topic in topics}
    asked = {re.sub("(/move_robot)/(goal|result|status)$", r"\1", topic) for topic in asked}
    assert "*/move_robot" in asked and len(asked) > 15
    assert asked - named == {"/rosout"}
    services = {names.COMMANDER_STATE, names.COMMANDER_WHY, names.SAFETY_STOP}
    assert services <= named
    called = set(re.findall(r"_call\(names\.(\w+),", inspect.getsource(links)))
    assert {getattr(names, name) for name in called} == services


def test_it_listens_on_loopback_alone(capsys, monkeypatch):
    monkeypatch.setattr("rospy.on_shutdown", lambda call: None)

    async def listening():
        node = asyncio.ensure_future(serve(web.Application(), ConsoleParams(port=0), "T"))
        said = ""
        while "#token=T" not in said:
            assert not node.done()
            await asyncio.sleep(0.01)
            said += capsys.readouterr().out
        port = int(re.search(r":(\d+)/#", said).group(1))
        sockets = psutil.Process().connections("tcp")
        node.cancel()
        return {each.laddr.ip for each in sockets if each.status == psutil.CONN_LISTEN and each.laddr.port == port}

    assert asyncio.run(asyncio.wait_for(listening(), 30.0)) == {"127.0.0.1"}


@pytest.fixture
def events():
    return EventLog()


def said(events):
    return decode(events.part().message)[0]["events"]


def test_events_are_warnings_and_the_commanders_words_and_repeat_as_a_count(events):
    before = events.part().version
    for level, node, text in (
        (Log.INFO, "/commander", "state 1"),
        (Log.INFO, "/database", "boring"),
        (Log.WARN, "/database", "no input"),
        (Log.WARN, "/database", "no input"),
        (Log.ERROR, "/simulation", "gone"),
    ):
        events.note(Log(level=level, name=node, msg=text))
    assert [(each["node"], each["level"], each["text"], each["times"]) for each in said(events)] == [
        ("commander", "info", "state 1", 1),
        ("database", "warning", "no input", 2),
        ("simulation", "error", "gone", 1),
    ]
    assert events.part().version > before


def test_events_do_not_grow_for_ever(events):
    for i in range(3 * MOST):
        events.note(Log(level=Log.WARN, name="/n", msg=f"{i}" * 1000))
    assert len(said(events)) == MOST
    assert len(events.part().message) < MOST * 600


@pytest.mark.parametrize(
    ("host", "token", "wanted"),
    [
        ("127.0.0.1", "T", "http://127.0.0.1:8/#token=T"),
        ("::1", "T", "http://[::1]:8/#token=T"),
        ("localhost", "", "http://localhost:8/"),
        ("10.0.0.7", "T", "http://10.0.0.7:8/?token=T"),
        ("0.0.0.0", "T", "http://THIS-MACHINE:8/?token=T"),
    ],
)
def test_the_address_brings_the_token_where_it_is_needed(host, token, wanted):
    assert address(host, 8, token) == wanted


@pytest.fixture
def heard(monkeypatch):
    """A view whose topics and clocks the test holds: callbacks by topic, and wall and simulated seconds."""
    topics, clock = {}, {"wall": 100.0, "simulated": 10.0}
    monkeypatch.setattr("rospy.Subscriber", lambda topic, _, callback, **__: topics.setdefault(topic, callback))
    monkeypatch.setattr("rospy.get_time", lambda: clock["simulated"])
    monkeypatch.setattr("rospy.get_param", lambda name, default: default)
    held = SimpleNamespace(monotonic=lambda: clock["wall"])
    monkeypatch.setattr("yarm.ros.console.view.time", held)
    monkeypatch.setattr("yarm.ros.console.routes.time", held)
    return LiveView(ConsoleParams()), topics, clock


def silent(view):
    return decode(view.state())[0]["silent"]


def test_who_was_never_heard_is_named(heard):
    view, _, _ = heard
    assert [line.partition(" yet")[0] for line in silent(view)] == [
        f"nothing heard from {sender}" for sender in SENDERS.values()
    ]


def test_who_falls_silent_is_named_by_the_time_of_a_slow_simulator_too(heard):
    view, topics, clock = heard
    topics[names.COMMANDER_STATUS](CommanderStatus(state=3, state_name="MENU"))
    topics[names.SAFETY_STATUS](SafetyStatus())
    about = [names.COMMANDER_NODE, names.SAFETY_NODE]

    def named():
        return [
            node for node in about if any(re.search(rf"from {node} \(\S+\) for \d+ s:", line) for line in silent(view))
        ]

    assert named() == []
    for _ in range(4):
        clock["wall"], clock["simulated"] = clock["wall"] + 2.5, clock["simulated"] + 0.5
        assert named() == [], "a status a second is no silence when seconds are slow"
    clock["wall"], clock["simulated"] = clock["wall"] + 2.5, clock["simulated"] + 2.5
    assert named() == about
    topics[names.COMMANDER_STATUS](CommanderStatus(state=3, state_name="MENU"))
    assert named() == [names.SAFETY_NODE]


def test_a_clock_that_stands_is_told(heard):
    view, _, clock = heard
    assert not any("stands still" in line for line in silent(view))
    clock["wall"] += 7.0
    assert "simulated time stands still for 7 s: what is shown is old" in silent(view)


def test_stamps_are_read_from_messages_and_from_bytes():
    status = SafetyStatus()
    status.header.stamp = rospy.Time(12, 500_000_000)
    raw = rospy.AnyMsg()
    raw.deserialize(serialised(status))
    assert stamp_of(status, SafetyStatus) == stamp_of(raw, SafetyStatus) == pytest.approx(12.5)
    assert stamp_of(TFMessage(), TFMessage) is None
    assert stamp_of(SafetyStatus(), SafetyStatus) is None


def test_the_same_warning_is_not_said_again_and_again():
    said, clock = [], SimpleNamespace(s=0.0)
    warn = throttled(said.append, lambda: clock.s)
    for _ in range(3):
        warn("a")
        warn("b")
    assert said == ["a", "b"]
    clock.s += AGAIN_S
    warn("a")
    assert said == ["a", "b", "a"]


def test_poses_are_read_from_messages_and_from_bytes_alike():
    message = TFMessage([transform("world", "/a", 1.5), transform("map", "odom", 2.0), transform("odom", "base", 0.5)])
    raw = rospy.AnyMsg()
    raw.deserialize(serialised(message))
    for each in (message, raw):
        book = PoseBook(pytest.fail)
        book.routes()["/tf"].take(each)
        assert book.newest() == {"a": (1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)}
        assert book.matrix("map", "base")[0, 3] == 2.5
        assert book.matrix("base", "map") is None


def test_a_film_beside_an_experiment_listens_to_poses_as_the_experiment_does(monkeypatch):
    kinds, waiting = {}, set()

    def subscribe(topic, kind, _, queue_size, buff_size, **__):
        kinds[topic] = kind
        waiting.add((queue_size, buff_size))

    monkeypatch.setattr("rospy.Subscriber", subscribe)
    Filmer("a run", 5.0, lambda: 0.0).end()
    assert kinds["/tf"] is kinds["/tf_static"] is TFMessage
    assert kinds[names.PLANNING_METADATA] is rospy.AnyMsg
    assert waiting == {(None, DEFAULT_BUFF_SIZE)}, "the last word on how many messages wait counts for all"


def test_a_latched_message_that_comes_while_subscribing_is_followed(monkeypatch):
    robot = RegisteredObject(name="ankurbot_1", object="Mobile", type="dynamic", seed_frame="a")
    topics = set()

    def subscribe(topic, _, take, **__):
        topics.add(topic)
        if topic == names.OBJECT_REGISTRY:
            take(ObjectRegistry(entries=[robot]))

    monkeypatch.setattr("rospy.Subscriber", subscribe)
    monkeypatch.setattr("rospy.get_time", lambda: 1.0)
    made = threading.Thread(target=lambda: Feed(SystemBook(lambda _: [], pytest.fail)), daemon=True)
    made.start()
    made.join(20.0)
    assert not made.is_alive(), "it waits for itself"
    assert f"{names.move_robot('ankurbot_1')}/goal" in topics
