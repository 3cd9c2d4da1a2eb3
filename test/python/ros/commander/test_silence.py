"""When no map comes the node's watch takes over: in real time soon, in lock-step only when time has gone on without."""

from __future__ import annotations

from typing import Callable, List

import pytest
import rospy
from yarm.msg import MapMetaData

from support import golden
from support.ears import Ears
from yarm.commander.events import Event, Tick
from yarm.commander.params import CommanderParams
from yarm.ros.commander import node as module
from yarm.ros.commander.node import SILENCE_S, CommanderNode
from yarm.ros.common import names

MAP = golden.load().sets[0]
MAP_S = MAP.stamp_ns / 1e9
Watched = Callable[[float, float], List[Event]]


@pytest.fixture(name="watched", params=(False, True), ids=("real_time", "lock_step"))
def watched_fixture(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Watched:
    """A Commander that has had one map: what its core is told at a simulated time, so much wall time after that, s."""
    ears = Ears()
    ears.put_on(monkeypatch)
    wall_s = 1000.0
    monkeypatch.setattr(module.time, "monotonic", lambda: wall_s)
    monkeypatch.setattr(rospy, "get_time", lambda: MAP_S)
    node = CommanderNode(CommanderParams(sync=request.param))
    (ear,) = ears.by_topic(names.PLANNING_METADATA)
    ear.tell(golden.from_bytes(MapMetaData, MAP.metadata), lambda: None)

    def watched(sim_s: float, later_s: float) -> List[Event]:
        told: List[Event] = []
        with monkeypatch.context() as patch:
            patch.setattr(module.time, "monotonic", lambda: wall_s + later_s)
            patch.setattr(rospy, "get_time", lambda: sim_s)
            patch.setattr(node, "_step", lambda event, _: told.append(event))
            node._watch()
        return told

    return watched


@pytest.mark.parametrize("watched", [True], ids=["lock_step"], indirect=True)
def test_in_lock_step_a_map_that_takes_long_is_waited_for(watched: Watched) -> None:
    """What came meanwhile counts with that map, as on a quick machine."""
    assert watched(MAP_S + 1 / 30, 60.0) == []


@pytest.mark.parametrize("watched", [False], ids=["real_time"], indirect=True)
def test_in_real_time_it_is_missed(watched: Watched) -> None:
    assert watched(MAP_S + 1 / 30, 60.0) == [Tick()]


def test_one_that_time_has_passed_is_missed(watched: Watched) -> None:
    assert watched(MAP_S + 1.1 * SILENCE_S, 1.1 * SILENCE_S) == [Tick()]
    assert watched(MAP_S + 1.1 * SILENCE_S, 0.9 * SILENCE_S) == []


def test_so_is_every_one_when_time_has_gone_back(watched: Watched) -> None:
    assert watched(MAP_S - 1.0, 60.0) == [Tick()]
