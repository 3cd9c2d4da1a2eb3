"""Scripted events fire once, at their trigger, after their delay."""

from __future__ import annotations

from yarm.sim.scenes.events import Event, Script, Situation, Trigger


def names(script: Script, now: Situation) -> list:
    return [event.name for event in script.fired(now)]


def test_time_and_delay() -> None:
    script = Script((Event("late", Trigger(time_s=2.0, after_s=0.5), delete="x"),))
    assert names(script, Situation(1.9)) == []
    assert names(script, Situation(2.0)) == []
    assert names(script, Situation(2.4)) == []
    assert names(script, Situation(2.5)) == ["late"]
    assert names(script, Situation(3.0)) == []


def test_commander_state_raster_and_distance() -> None:
    script = Script(
        (
            Event("state", Trigger(state="BOUNDLESS"), delete="x"),
            Event("raster", Trigger(raster=0.5), delete="x"),
            Event("near", Trigger(robots=("q", "r"), near="d", below_m=0.5), delete="x"),
        )
    )
    assert names(script, Situation(0.0, "MENU", {"a": 0.4}, {"r": (0.0, 0.0), "d": (0.5, 0.0)})) == []
    assert names(script, Situation(1.0, "BOUNDLESS", {"a": 0.4}, {"r": (0.0, 0.0)})) == ["state"]
    assert names(script, Situation(2.0, "MENU", {"a": 0.5})) == ["raster"]
    assert names(script, Situation(3.0, "", {}, {"r": (0.0, 0.0), "d": (0.3, 0.39)})) == ["near"]


def test_a_raster_may_be_one_manipulators_or_anyones() -> None:
    events = (Event("own", Trigger(raster=0.5, arm="b"), delete="x"), Event("any", Trigger(raster=0.5), delete="x"))
    script = Script(events)
    assert names(script, Situation(1.0, "", {"a": 0.4, "b": 0.3})) == []
    assert names(script, Situation(2.0, "", {"a": 0.6, "b": 0.3})) == ["any"]
    assert names(script, Situation(3.0, "", {"a": 0.6, "b": 0.5})) == ["own"]


def test_an_event_can_be_tried_again() -> None:
    event = Event("spawn", Trigger(time_s=1.0), delete="x")
    script = Script((event,))
    assert script.fired(Situation(1.0)) == (event,)
    script.again(event, 2.0)
    assert script.fired(Situation(1.5)) == ()
    assert script.fired(Situation(2.0)) == (event,)


def test_what_hangs_on_a_hand_triggers() -> None:
    script = Script((Event("slips", Trigger(holding="r", after_s=0.5), vacuum="r", enabled=False),))
    assert names(script, Situation(1.0, holding=frozenset("q"))) == []
    assert names(script, Situation(2.0, holding=frozenset("qr"))) == []
    assert names(script, Situation(2.5)) == ["slips"]
