"""The page in a real browser without a cell: widths, keyboard, what it keeps, and a run of the arm."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

from support.console_stand import RecordingCell
from support.page_desk import DESK, LIMIT_S, PHONE, READY, VIEW_FROM, leave, page_of
from support.page_stand import SMALL_PX, TOKEN, BusyCellView, live, page_served
from yarm.commander.states import STATE_DOCS, State
from yarm.console.cell import Part
from yarm.console.film import Film
from yarm.console.floor_film import FloorFilm
from yarm.console.picture import BodyDrawing
from yarm.manipulation.kinematics.forward import forward
from yarm.manipulation.motion.checkpoints import ArmScene, Checkpoint
from yarm.manipulation.motion.trajectory import arm_limits, quintic
from yarm.manipulation.obstacles.physics import ArmWorld

LEAST_PX = 24
OUTSIDE = """[...document.querySelectorAll("button, input, select, summary")].filter((each) => {
  const box = each.getBoundingClientRect();
  return each.checkVisibility() && box.width && (box.left < 0 || box.right > innerWidth + 1);
}).map((each) => each.outerHTML)"""
SMALL = """[...document.querySelectorAll("button")].filter((each) => {
  const box = each.getBoundingClientRect();
  return each.checkVisibility() && box.width && box.height < %d;
}).map((each) => each.outerHTML)"""
STOP_IN_SIGHT = """(() => {
  const box = document.querySelector("#stop").getBoundingClientRect();
  const met = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
  return box.top >= 0 && box.bottom <= innerHeight && met.id === "stop";
})()"""
REACHABLE = """(() => {
  window.wanted = [...document.querySelectorAll("button, input, select, summary, canvas")].filter(
    (each) => !each.disabled && each.checkVisibility());
  return wanted.length;
})()"""
TO_THE_END = """((range) => {
  range.value = range.max;
  range.dispatchEvent(new Event("input"));
})(document.querySelector("#when"))"""
NARROWEST_GOAL = "Math.min(...[...document.querySelectorAll('#tasks td:first-child')].map((cell) => cell.clientWidth))"
NAME_PX = 80
CUT_OFF = "document.querySelector('aside').scrollWidth - document.querySelector('aside').clientWidth"
PRESETS = "[...document.querySelectorAll('#presets button')].map((each) => each.textContent)"
NAMES = """
[...document.querySelectorAll("#labels span")].filter((each) => each.checkVisibility()).map((each) => {
  const box = each.getBoundingClientRect();
  return [each.textContent, box.left, box.top, box.right, box.bottom];
})
"""
SAID = """
[...document.querySelectorAll("#said tbody tr")].map((row) => [...row.cells].map((cell) => cell.textContent))
"""
START, END = np.array([0.0, 0.3, 0.8, 0.6, 0.0]), np.array([0.2, 0.3, 0.8, 0.7, 0.0])


def test_everything_is_within_a_desks_and_a_phones_width_and_the_stop_always_in_sight(desk, tmp_path):
    async def look():
        async with page_of(desk, BusyCellView(busy=False), tmp_path) as browser:
            assert await browser.run("document.documentElement.scrollWidth") <= DESK[0]
            assert await browser.run("document.documentElement.scrollHeight") <= DESK[1]
            assert await browser.run(OUTSIDE) == []
            assert await browser.run(CUT_OFF) <= 0
            assert await browser.run(NARROWEST_GOAL) > NAME_PX, "the names of goals are broken"
            assert await browser.run("document.querySelector('#view').clientWidth") > 0.5 * DESK[0]
            assert await browser.run(STOP_IN_SIGHT)
        async with page_of(desk, BusyCellView(busy=False), tmp_path, size=PHONE) as browser:
            assert await browser.run("document.documentElement.scrollWidth") <= PHONE[0]
            assert await browser.run(OUTSIDE) == []
            assert await browser.run(SMALL % LEAST_PX) == []
            assert await browser.run(STOP_IN_SIGHT)
            await browser.run("scrollTo(0, document.documentElement.scrollHeight)")
            assert await browser.run("scrollY") > 0
            assert await browser.run(STOP_IN_SIGHT)

    desk.run(look())


def names_over_another(boxes):
    """Names, of which a page shows the boxes, that share some of it."""
    pairs = itertools.combinations(boxes, 2)
    return [
        (a[0], b[0])
        for a, b in pairs
        if min(a[3], b[3]) - max(a[1], b[1]) > 1 and min(a[4], b[4]) - max(a[2], b[2]) > 1
    ]


class HeapView(BusyCellView):
    """A cell with pieces on one heap."""

    PIECES = ("piece_1", "piece_2", "piece_3")

    def _scene(self):
        scene = super()._scene()
        heap = [BodyDrawing(name, "Debris", "dynamic", "piece") for name in self.PIECES]
        return replace(scene, bodies=[*scene.bodies, *heap])


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_no_name_lies_over_another(desk, tmp_path, size):
    async def look():
        async with page_of(desk, HeapView(), tmp_path, size=size) as browser:
            for preset in await browser.run(PRESETS):
                await browser.run(VIEW_FROM % preset)
                drawn = await browser.run("yarmConsole.pictures()")
                await browser.until(f"yarmConsole.pictures() > {drawn + 1}", LIMIT_S)
                boxes = await browser.run(NAMES)
                assert names_over_another(boxes) == [], preset
                assert preset != "top" or set(HeapView.PIECES) < {name for name, *_ in boxes}, boxes

    desk.run(look())


def test_each_layer_can_be_switched_off_and_on_and_each_view_is_taken_from_its_place(desk, tmp_path):
    async def look():
        async with page_of(desk, BusyCellView(busy=False), tmp_path) as browser:
            before = await browser.run("yarmConsole.drawn()")
            layers = await browser.run(
                "[...document.querySelectorAll('#layer-list input')].map((each) => each.dataset.layer)"
            )
            assert set(layers) == set(before) and all(before.values())
            for layer in layers:
                press = f"document.querySelector('#layer-list [data-layer={layer}]').click()"
                await browser.run(press)
                assert await browser.run("yarmConsole.drawn()") == {**before, layer: False}
                await browser.run(press)
            assert await browser.run("yarmConsole.drawn()") == before
            eyes = {}
            for name in ("top", "camera 1", "camera 4", "corner"):
                await browser.run(VIEW_FROM % name)
                eyes[name] = await browser.run("yarmConsole.eye()")
            assert np.hypot(*eyes["top"][:2]) < 0.1 and eyes["top"][2] > 5.0
            assert eyes["corner"][1] < -2.0 < 2.0 < eyes["corner"][0]
            gap = np.subtract(eyes["camera 4"], eyes["camera 1"])
            np.testing.assert_allclose(gap, (4.5, 0.0, 0.0), atol=1e-3)

    desk.run(look())


TASK = {"goal": "debris_1", "kind": "Debris", "robot": "a", "status": "moving", "reason": "", "left_m": 1.24}
ARM = {"name": "hc10", "state": "scan to path", "sands": True, "enabled": True, "progress": 0.14, "reason": ""}
STILL_HEADER = {"commander": {"state": "BOUNDLESS"}, "tasks": [], "robots": [], "arms": [], "stop": {"latched": False}}


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ({}, []),
        ({"commander": None, "arms": [ARM]}, []),
        ({"tasks": [TASK]}, ["a drives to debris_1, 1.2 m to go", "0 of 1 goals done."]),
        (
            {"tasks": [{**TASK, "status": "carrying"}, {**TASK, "goal": "bin_1/a", "kind": "Bin"}]},
            ["a carries debris_1 to bin_1, 1.2 m to go", "0 of 1 goals done."],
        ),
        ({"tasks": [{**TASK, "status": "picking"}]}, ["a picks up debris_1", "0 of 1 goals done."]),
        ({"tasks": [{**TASK, "status": "dropping"}]}, ["a lets go of debris_1", "0 of 1 goals done."]),
        ({"tasks": [{**TASK, "status": "reached"}]}, ["a has nothing to do", "1 of 1 goals done."]),
        ({"tasks": [{**TASK, "goal": "home/a", "kind": "Home"}]}, ["a drives home, 1.2 m to go"]),
        (
            {"tasks": [{**TASK, "status": "failed", "reason": "lost"}]},
            ["a gave up debris_1: lost", "0 of 1 goals done."],
        ),
        (
            {"tasks": [{**TASK, "status": "unreachable", "robot": "", "reason": "a wall"}]},
            ["Nobody can reach debris_1: a wall", "0 of 1 goals done."],
        ),
        (
            {"tasks": [{**TASK, "status": "waiting", "robot": "", "left_m": None}]},
            ["debris_1 waits for a robot", "0 of 1 goals done."],
        ),
        (
            {"tasks": [{**TASK, "status": "carrying"}, {**TASK, "goal": "clear/a", "kind": "Clear"}]},
            ["a carries debris_1 and makes way, 1.2 m to go", "0 of 1 goals done."],
        ),
        ({"tasks": [{**TASK, "goal": "clear/a", "kind": "Clear"}]}, ["a makes way, 1.2 m to go"]),
        (
            {"tasks": [{**TASK, "goal": "inside/a", "kind": "Clear", "status": "backing_out"}]},
            ["a backs out from a manipulator's area"],
        ),
        (
            {
                "tasks": [
                    {**TASK, "goal": "bin_1/a", "kind": "Bin", "robot": "", "status": "unreachable", "reason": "b"}
                ]
            },
            ["a cannot get to bin_1: b"],
        ),
        (
            {"tasks": [{**TASK, "goal": "bin_1/a", "kind": "Bin", "robot": "", "status": "waiting"}]},
            ["a waits for its way to bin_1"],
        ),
        ({"robots": [{"name": "a", "held": True}]}, ["a has nothing to do; the safety monitor holds it"]),
        ({"arms": [ARM]}, ["hc10 sands the part, 14 % of its raster done"]),
        ({"arms": [{**ARM, "enabled": False}]}, ["hc10 pauses; 14 % of its raster done"]),
        ({"arms": [{**ARM, "sands": False, "state": "storage"}]}, ["hc10: storage"]),
        ({"stop": {"latched": True}}, ["Everything is stopped until somebody releases it."]),
    ],
)
def test_what_goes_on_is_said_in_sentences(desk, plain_page, header, said):
    words = json.dumps({**STILL_HEADER, **header})
    assert desk.run(plain_page.run(f"import('/now.js').then((now) => now.sentences({words}))")) == said


@pytest.fixture(name="plain_page", scope="module")
def plain_page_fixture(desk, tmp_path_factory):
    """A page of the console's that is only there for its modules."""
    opened = contextlib.AsyncExitStack()
    results = tmp_path_factory.mktemp("results")
    view = BusyCellView(busy=False)
    yield desk.run(opened.enter_async_context(page_of(desk, view, results)))
    desk.run(opened.aclose())


def test_the_panel_says_what_goes_on_and_how_each_camera_and_action_server_is(desk, tmp_path):
    async def read():
        async with page_of(desk, BusyCellView(busy=False), tmp_path) as browser:
            now = await browser.run("[...document.querySelectorAll('#now li')].map((each) => each.textContent)")
            assert now[0] == "ankurbot_1 drives to debris_0, 1.3 m to go"
            assert now[1] == "hc10_barc pauses: ankurbot_1 too near; 40 % of its raster done"
            assert await browser.run("document.querySelector('#means').textContent") == STATE_DOCS[State.MENU]
            await browser.until(f"({SAID}).length > 5", LIMIT_S)
            said = {row[0]: row[1:] for row in await browser.run(SAID)}
            assert said["camera 1"] == ["\u2713 ok", "silent for, s: 0.033"]
            assert said["camera 2"] == ["\u2716 error", "camera_2: blind: 3 % of its points"]
            assert said["camera 4"] == ["\u2026 stale", "nobody says anything of it"]
            assert said["action server of ankurbot_1"] == ["\u2716 error", "silent for 4 s"]
            assert "to look at" in await browser.run("document.querySelector('#health-title').textContent")

    desk.run(read())


PRESS_NEWEST_EVENT = """(() => {
  const button = document.querySelector("#event-list button");
  button.click();
  return Number.parseFloat(button.textContent);
})()"""


def test_an_events_time_leads_to_its_moment_while_the_cell_goes_on_and_back_to_now(desk, tmp_path):
    async def look():
        async with page_of(desk, BusyCellView(), tmp_path) as browser:
            await browser.until("yarmConsole.newest().time_s > 3", LIMIT_S)
            at_s = await browser.run(PRESS_NEWEST_EVENT)
            shown = "yarmConsole.watching() === 'film' && yarmConsole.film().settled && yarmConsole.newest().time_s"
            assert abs(await browser.until(shown, LIMIT_S) - at_s) < 1.0
            assert await browser.run("document.body.classList.contains('past')")
            pictures = await browser.run("yarmConsole.pictures()")
            await browser.until(f"yarmConsole.pictures() > {pictures + 3}", LIMIT_S)
            await browser.run("document.querySelector('#to-live').click()")
            await browser.until(
                f"yarmConsole.watching() === 'live' && yarmConsole.newest().time_s > {at_s + 1}", LIMIT_S
            )

    desk.run(look())


def test_a_page_whose_experiment_has_ended_goes_over_to_its_film(desk, tmp_path):
    view, film = BusyCellView(), Film("the run")
    for _ in range(20):
        film.add(view.now_s(), view.parts(), view.state())

    async def watch():
        browser = await desk.browser.another()
        async with page_served(live(RecordingCell(), view), str(tmp_path)) as address:
            await browser.open(f"{address}#token={TOKEN}")
            await browser.until(READY, LIMIT_S)
        port = int(address.rstrip("/").rpartition(":")[2])
        async with page_served(film, str(tmp_path), port=port):
            await browser.until(
                "window.yarmConsole && document.body.classList.contains('recorded') && yarmConsole.newest()", LIMIT_S
            )
            assert await browser.run("document.querySelector('#past-title').textContent") == "the run"
            assert await browser.run("yarmConsole.watching()") == "film"
            await browser.until(
                "yarmConsole.film().settled && yarmConsole.film().at_s === yarmConsole.film().last_s", LIMIT_S
            )
            await leave(browser)

    desk.run(watch())


HOLD_FILM = """(() => {
  const fetched = window.fetch;
  window.come = 0;
  const until = new Promise((release) => (window.release = release));
  window.fetch = async (address) => {
    const answer = await fetched(address);
    if (/film\\/\\d/.test(address)) await until.then(() => (window.come += 1));
    return answer;
  };
})()"""
ASK_FOR = """((range, time_s) => {
  range.value = time_s;
  range.dispatchEvent(new Event("input"));
  return Number(range.value);
})(document.querySelector("#when"), %s)"""


def test_a_moment_that_is_asked_for_while_a_step_waits_for_pictures_is_what_is_shown(desk, tmp_path):
    view, film = BusyCellView(), Film("the run")
    for _ in range(160):
        film.add(view.now_s(), view.parts(), view.state())

    async def look():
        browser = await desk.browser.another()
        async with page_served(film, str(tmp_path)) as address:
            await browser.open(address)
            shown = "window.yarmConsole && yarmConsole.newest() && yarmConsole.film().settled"
            await browser.until(shown, LIMIT_S)
            assert await browser.run("yarmConsole.film().unpacked") == 1
            await browser.run(HOLD_FILM)
            await browser.run("document.querySelector('#step-on').click()")
            wanted_s = await browser.run(ASK_FOR % 2.0)
            await browser.run("release()")
            await browser.until("come >= 3 && yarmConsole.film().unpacked === 4", LIMIT_S)
            await browser.run("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            await browser.until(shown, LIMIT_S)
            assert await browser.run("yarmConsole.film().at_s") == pytest.approx(wanted_s)
            await browser.run("document.querySelector('#step-on').click()")
            await browser.until(f"yarmConsole.film().at_s > {wanted_s + 0.05}", LIMIT_S)
            assert await browser.run("yarmConsole.film().at_s") == pytest.approx(wanted_s + 0.1)
            await leave(browser)

    desk.run(look())


async def key(browser, name, code):
    """A key is pressed and let go."""
    given = {"key": name, "windowsVirtualKeyCode": code}
    await browser.call("Input.dispatchKeyEvent", type="rawKeyDown", **given)
    await browser.call("Input.dispatchKeyEvent", type="keyUp", **given)


def test_everything_can_be_reached_and_stopped_by_keyboard(desk, tmp_path):
    cell = RecordingCell()

    async def type_():
        async with page_of(desk, BusyCellView(busy=False), tmp_path, cell) as browser:
            count = await browser.run(REACHABLE)
            assert count > 15
            reached = set()
            for _ in range(2 * count):
                await key(browser, "Tab", 9)
                reached.add(await browser.run("wanted.indexOf(document.activeElement)"))
            missed = f"wanted.filter((_, i) => !{sorted(reached)}.includes(i)).map((each) => each.outerHTML)"
            assert await browser.run(missed) == []
            await browser.run("document.activeElement.blur()")
            await key(browser, "Escape", 27)
            await key(browser, "x", 88)
            assert cell.calls == []
            await stopped_by(browser, cell, key(browser, "s", 83))
            await stopped_by(browser, cell, key(browser, "Escape", 27), key(browser, "Escape", 27))

    desk.run(type_())


async def stopped_by(browser, cell, *keys):
    """These keys, at once, stop the cell."""
    cell.calls.clear()
    await browser.run("document.querySelector('#answer').textContent = ''")
    await asyncio.gather(*keys)
    await browser.until("document.querySelector('#answer').textContent === 'everything stands'", LIMIT_S)
    assert set(cell.calls) == {("stop",)}


def test_what_it_keeps_does_not_grow_with_the_pictures(desk, tmp_path):
    """Every picture has other cells, ways and places, every tenth other bodies and events."""

    async def watch():
        async with page_of(desk, BusyCellView(), tmp_path, size=SMALL_PX) as browser:
            await browser.until("yarmConsole.pictures() > 60", LIMIT_S)
            before = await held(browser)
            await browser.until("yarmConsole.pictures() > 160", LIMIT_S)
            after = await held(browser)
            assert after["geometries"] <= before["geometries"] + 1, (before, after)
            assert after["textures"] == before["textures"], (before, after)
            assert after["labels"] <= before["labels"] + 1, (before, after)
            assert after["nodes"] < 1.5 * before["nodes"], (before, after)

    desk.run(watch())


class LateView(BusyCellView):
    """A cell that, once it is late, has another piece with every tenth picture, and poses of the first scene still."""

    def __init__(self):
        super().__init__(busy=False)
        self.late = False

    def parts(self):
        version = 1 + self._made // 10 if self.late else 0
        piece = BodyDrawing(f"new_{version}", "Debris", "dynamic", f"new_{version}")
        scene = self._scene()
        drawn = replace(scene, bodies=[*scene.bodies, piece])
        return {**super().parts(), "scene": Part(version, drawn.message(version))}


def test_what_was_there_before_is_shown_while_the_poses_of_a_new_scene_are_on_their_way(desk, tmp_path):
    async def look():
        view = LateView()
        async with page_of(desk, view, tmp_path, size=SMALL_PX) as browser:
            await browser.until("yarmConsole.bodies().filter((body) => body.at).length === 3", LIMIT_S)
            view.late, before = True, await browser.run("yarmConsole.pictures()")
            await browser.until(f"yarmConsole.pictures() > {before + 30}", LIMIT_S)
            *known, new = await browser.run("yarmConsole.bodies()")
            assert [body["at"] is not None for body in known] == [True, True], known
            assert new["name"] not in ("new_0", "debris_0") and new["at"] is None, new

    desk.run(look())


async def held(browser):
    await browser.call("HeapProfiler.collectGarbage")
    counted = await browser.call("Memory.getDOMCounters")
    return {**await browser.run("yarmConsole.held()"), "nodes": counted["nodes"]}


def test_a_run_of_the_arm_is_played_with_its_checkpoints_and_ways(desk, tmp_path):
    film, scene = FloorFilm("arm"), ArmScene("test", START, (Checkpoint("there", forward(END)),), ())
    with ArmWorld(scene) as world:
        world.play([quintic(START, END, arm_limits())], film.arm("to one place", scene))

    async def play():
        async with page_served(film.reel.film, str(tmp_path)) as address:
            browser = await desk.browser.another()
            await browser.open(address)
            await browser.until("window.yarmConsole && yarmConsole.newest() && yarmConsole.room().marks === 2", LIMIT_S)
            assert [body["name"] for body in await browser.run("yarmConsole.bodies()")] == ["arm"]
            assert await browser.run("yarmConsole.room().texts") == 1
            title = "document.querySelector('#room-title').textContent"
            assert await browser.run(title) == "youBot's arm: to one place"
            await browser.run(TO_THE_END)
            reached = "document.querySelector('#room-facts').textContent.includes('1 of 1 checkpoints')"
            await browser.until(reached, LIMIT_S)
            layers = await browser.run("yarmConsole.newest().lines.map((line) => line.layer).join()")
            assert layers == "driven,path"
            assert "the hand is at there" in await browser.run("document.querySelector('#event-list').textContent")
            assert browser.errors == []
            await leave(browser)

    desk.run(play())
