#!/usr/bin/env python3
"""A person opens the page, compares it with the cell, runs a mission by its buttons, stops it, loses the console."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

import numpy as np
import psutil
import rospy
import rostest
from tf2_msgs.msg import TFMessage
from yarm.msg import CommanderStatus, ObjectRegistry, SafetyStatus
from yarm.srv import SpawnObstaclesRequest

from yarm.console.film import Film, unpack
from yarm.console.results import FILM, SUMMARY
from yarm.console.wire import decode
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.console.recorded import recorded

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.browser import chromium
from support.commander_driver import CommanderDriver
from support.room_bag import LENGTH_S, ODOM_AT_M, SPEED_MPS, write_room_bag

ROBOT, TARGET = "ankurbot_1", "target_1"
RESULTS = Path(os.environ["ROS_HOME"]) / "kept"
SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
LOAD = Path(__file__).resolve().parents[1] / "support" / "console_load.py"
NEAR_M = 0.05
REST_S, RESTS_FOR_S, REST_MPS = 0.5, 1.0, 0.03
SOON_S = 0.1
ROUNDING_S = 1e-6
SEEK = """(() => {
  const range = document.querySelector("#when");
  range.value = Number(range.min) + %s * (range.max - range.min);
  range.dispatchEvent(new Event("input"));
  return Number(range.value);
})()"""
PRESS = """(() => {
  const buttons = [...document.querySelectorAll("#buttons button")];
  const button = buttons.find((each) => each.dataset.target === "%s" && !each.disabled);
  if (button) button.click();
  return Boolean(button);
})()"""


def film_at(base):
    """The film that a console keeps."""
    with urllib.request.urlopen(f"{base}film") as answer:
        index = json.load(answer)
    film = Film("the last minutes")
    for i in range(len(index["blocks"])):
        with urllib.request.urlopen(f"{base}film/{index['first'] + i}") as answer:
            film.take(index["blocks"][i], answer.read())
    return film


class ConsoleTest(CommanderDriver):
    """The tests build on each other, in the order of their names."""

    LIMIT_S = 120.0

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.rmtree(RESULTS, ignore_errors=True)
        cls.track, cls.frames, cls.safety = [], {}, SafetyStatus()
        for topic in ("/tf", "/tf_static"):
            rospy.Subscriber(topic, TFMessage, cls.on_tf, queue_size=1000)
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, cls.on_safety, queue_size=100)
        cls.registry = rospy.wait_for_message(names.OBJECT_REGISTRY, ObjectRegistry, timeout=cls.LIMIT_S)
        cls.address = cls.start_console(0)
        cls.loop, cls.open = asyncio.new_event_loop(), contextlib.AsyncExitStack()
        cls.browser = cls.loop.run_until_complete(cls.open.enter_async_context(chromium()))

    @classmethod
    def start_console(cls, port, program=("rosrun", "yarm", "console")):
        """Start one on a port, and give the address that it prints."""
        cls.console = subprocess.Popen(
            [*program, f"_port:={port}", f"_results:={RESULTS}"],
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        said = iter(cls.console.stdout.readline, "")
        return next(match for match in (re.search(r"http://\S+", line) for line in said) if match).group()

    @classmethod
    def tearDownClass(cls):
        cls.loop.run_until_complete(cls.open.aclose())
        cls.console.kill()
        cls.console.wait()

    @classmethod
    def on_tf(cls, message):
        with cls.condition:
            for transform in message.transforms:
                at = transform.transform.translation
                frame, place = transform.child_frame_id.lstrip("/"), np.array((at.x, at.y, at.z))
                cls.frames[frame] = place
                if frame == names.ee_frame(ROBOT):
                    cls.track.append((transform.header.stamp.to_sec(), place))
            cls.condition.notify_all()

    @classmethod
    def on_safety(cls, message):
        with cls.condition:
            cls.safety = message
            cls.condition.notify_all()

    def page(self, script):
        """Value of an expression in the page."""
        return self.loop.run_until_complete(self.browser.run(script))

    def shows(self, script):
        """Until an expression in the page is true; its value."""
        return self.loop.run_until_complete(self.browser.until(script, self.LIMIT_S))

    def press(self, state):
        """The button that leads to a state, as soon as it may be pressed; then the page and the Commander are there."""
        self.shows(PRESS % state)
        self.shows(f"document.querySelector('#state').textContent.startsWith('{state}')")
        self.assertEqual(self.page("document.querySelector('#answer').className"), "", "an answer that is a refusal")

    def speed(self, since_s, until_s):
        self.wait(lambda: self.track[-1][0] >= until_s, "poses of the robot")
        with self.condition:
            found = [sample for sample in self.track if since_s <= sample[0] <= until_s]
        steps = [np.abs(b - a).max() / (t - s) for (s, a), (t, b) in zip(found, found[1:]) if t > s]
        self.assertGreater(len(steps), 10)
        return max(steps)

    @staticmethod
    def stands(before, after):
        return np.abs(after[1] - before[1]).max() < REST_MPS * (after[0] - before[0])

    def drives(self):
        (s, a), (t, b) = self.track[-10], self.track[-1]
        return t > s and np.abs(b - a).max() / (t - s) > 0.3

    def test_1_the_page_shows_what_the_simulator_holds(self):
        self.loop.run_until_complete(self.browser.open(self.address))
        self.shows("window.yarmConsole && yarmConsole.pictures() > 1 && yarmConsole.cellsDrawn() > 0")
        self.assertNotIn("token", self.page("location.href"), "the token stays in the address")
        frames = {entry.name: entry.seed_frame.lstrip("/") for entry in self.registry.entries}
        self.wait(lambda: set(frames.values()) <= set(self.frames), "poses of all bodies from the simulator")
        shown = {body["name"]: body for body in self.page("yarmConsole.bodies()")}
        self.assertEqual(set(shown), set(frames))
        for entry in self.registry.entries:
            body, at = shown[entry.name], self.frames[frames[entry.name]]
            self.assertEqual((body["kind"], body["meshes"]), (entry.object, len(entry.shapes)), entry.name)
            self.assertLess(np.abs(at - body["at"]).max(), NEAR_M, entry.name)
        self.assertEqual(len(frames), 2, "the robot and the crate")
        cells = self.page("[yarmConsole.cells(), yarmConsole.cellsDrawn()]")
        self.assertEqual(sum(cells[0].values()), cells[1])
        self.assertGreater(cells[0][ROBOT], 100)
        self.page(f"yarmConsole.pick('{ROBOT}')")
        self.assertRegex(self.page("document.querySelector('#picked').innerText"), "in sight of: camera [1-4]")

    def test_2_its_buttons_lead_to_a_mission(self):
        for state in ("STARTED", "CALIBRATION", "MENU"):
            self.press(state)
        answer = self.spawn(SpawnObstaclesRequest(name=TARGET, type="Target", x=-1.6, y=0.6, z=0.89))
        self.assertTrue(answer.success, answer.message)
        self.shows(f"yarmConsole.bodies().some((body) => body.name === '{TARGET}' && body.at)")
        self.press("BOUNDLESS")
        self.assertEqual(self.status.state, CommanderStatus.BOUNDLESS)
        self.shows(f"document.querySelector('#tasks').textContent.includes('{TARGET}')")

    @contextlib.contextmanager
    def loaded(self):
        """The console served to a dozen greedy and hostile visitors meanwhile."""
        base = self.address.partition("#")[0]
        with subprocess.Popen([sys.executable, str(LOAD), base], stdout=subprocess.PIPE, text=True) as visitors:
            try:
                self.assertEqual(visitors.stdout.readline(), "loaded\n")
                yield
            finally:
                visitors.kill()

    def test_3_its_stop_stops_until_a_release_that_is_confirmed(self):
        """Also while the console's server is loaded."""
        with self.loaded():
            self.wait(self.drives, "the robot under way")
            pressed_s = self.track[-1][0]
            self.page("document.querySelector('#stop').click()")
            self.wait(lambda: self.safety.latched, "the monitor's word")
            heard_s = self.safety.header.stamp.to_sec()
            since_s = heard_s + REST_S
            self.assertLess(self.speed(since_s, since_s + RESTS_FOR_S), REST_MPS)
        busy = [error for error in self.browser.errors if "429" in error]  # files; the visitors have its address, too
        self.browser.errors = [error for error in self.browser.errors if error not in busy]
        rest_s = next(a[0] for a, b in zip(self.track, self.track[1:]) if a[0] > pressed_s and self.stands(a, b))
        rospy.loginfo(
            "from the press: latched after %.2f s, at rest after %.2f s", heard_s - pressed_s, rest_s - pressed_s
        )
        self.shows("document.querySelector('#stop-state').textContent.startsWith('STOPPED')")
        self.page("document.querySelector('#release').click()")
        self.shows("!document.querySelector('#confirm').hidden")
        self.assertTrue(self.safety.latched, "the first step alone releases nothing")
        self.page("document.querySelector('#confirm').click()")
        self.shows("!document.body.classList.contains('stopped')")
        self.wait(self.drives, "the robot under way again")

    def test_4_two_pages_show_the_same_and_one_looks_back_while_the_cell_goes_on(self):
        other = self.loop.run_until_complete(self.browser.another())
        self.loop.run_until_complete(other.open(self.address.partition("#")[0]))
        self.loop.run_until_complete(other.until("window.yarmConsole && yarmConsole.pictures() > 1", self.LIMIT_S))
        self.page("document.querySelector('#step-back').click()")
        self.shows("yarmConsole.watching() === 'film' && !yarmConsole.film().playing")
        for back in (0.2, 0.6):
            wanted_s = self.page(SEEK % back)
            shown_s = self.shows("yarmConsole.film().settled && yarmConsole.newest().time_s")
            self.assertEqual(shown_s, self.picture_of(wanted_s), f"the picture of {wanted_s} s")
            self.assert_robot_was_shown_where_it_was(shown_s)
        pictures = self.page("yarmConsole.pictures()")
        self.shows(f"yarmConsole.pictures() > {pictures + 2}")
        self.assertEqual(self.page("yarmConsole.newest().time_s"), shown_s, "live pictures are kept from the view")
        newest_s = self.loop.run_until_complete(other.run("yarmConsole.newest().time_s"))
        self.assertGreater(newest_s, shown_s)
        self.page("document.querySelector('#to-live').click()")
        self.shows(f"yarmConsole.watching() === 'live' && yarmConsole.newest().time_s > {newest_s}")
        self.shows("document.querySelector('#nodes').textContent.includes('Hz')")
        self.assertEqual(other.errors, [])
        self.loop.run_until_complete(other.close())

    def picture_of(self, time_s):
        """Time, as it says itself, of the picture that the console's film has of a moment; a slow machine takes few."""
        film = film_at(self.address.partition("#")[0])
        entries = [entry for number in range(len(film.index()["blocks"])) for entry in unpack(film.block(number))]
        heads = [(taken_s, decode(message)[0]) for taken_s, message in entries if taken_s <= time_s + ROUNDING_S]
        return next(head["time_s"] for _, head in reversed(heads) if head["kind"] == "state")

    def test_5_films_are_exported_as_files_that_ask_for_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "run.html"
            film_at(re.match(r"http://[^/]+/", self.address).group()).write(page.parent / FILM)
            (page.parent / SUMMARY).write_text("case: console\nsuccess: true\n")
            subprocess.run(["rosrun", "yarm", "console", "--run", page.parent, "--export", page], check=True)
            room = Path(folder) / "room.html"
            room.write_text(recorded(write_room_bag(room.with_suffix(".bag"))).page())
            self.loop.run_until_complete(self.look_at_files(page, room))

    async def look_at_files(self, page, room):
        """A cell's run and a room's, each in one file."""
        offline = await self.browser.another()
        await offline.open(page.as_uri())
        await offline.until("window.yarmConsole && yarmConsole.newest()", self.LIMIT_S)
        await offline.run(SEEK % 0.5)
        shown_s = await offline.until(
            "yarmConsole.newest().time_s > yarmConsole.film().first_s + 1 && yarmConsole.newest().time_s"
        )
        shown = {body["name"]: body["at"] for body in await offline.run("yarmConsole.bodies()")}
        self.assertLessEqual({entry.name for entry in self.registry.entries}, set(shown))
        self.assert_was_at(shown_s, shown[ROBOT])
        await offline.run("document.querySelector('#tab-results').click()")
        self.assertIn("success", await offline.run("document.querySelector('#run').innerText"))
        await offline.open(room.as_uri())
        await offline.until("window.yarmConsole && yarmConsole.newest() && yarmConsole.room().marks", self.LIMIT_S)
        await offline.run(SEEK % 1.0)
        await offline.until(
            f"Math.abs(yarmConsole.bodies()[0].at[0] - {ODOM_AT_M[0] + SPEED_MPS * LENGTH_S}) < {NEAR_M}"
        )
        self.assertEqual(len(await offline.run("yarmConsole.room().seen")), 4)
        self.assertIn("4.5 m", await offline.run("document.querySelector('#room').innerText"))
        self.assertEqual([each for each in offline.asked if each.startswith("http")], [])
        self.assertEqual(offline.errors, [])
        await offline.close()

    def assert_robot_was_shown_where_it_was(self, shown_s):
        self.assert_was_at(shown_s, self.page(f"yarmConsole.bodies().find((body) => body.name === '{ROBOT}').at"))

    def assert_was_at(self, time_s, at):
        """The robot was at this place then, within what it drives in the time between two poses."""
        with self.condition:
            near = [place for stamp_s, place in self.track if abs(stamp_s - time_s) < SOON_S]
        self.assertTrue(near, f"no pose about {time_s} s")
        self.assertLess(min(np.abs(place - at).max() for place in near), NEAR_M)

    def test_6_killed_it_changes_nothing_for_the_cell_and_the_page_says_so(self):
        self.assertEqual(self.browser.errors, [])
        base = re.match(r"http://[^/]+/", self.address).group()
        self.assertEqual([each for each in self.browser.asked if not each.startswith(base)], [])
        self.console.kill()
        self.shows("document.querySelector('#banner').textContent.includes('no connection to the console')")
        self.ended()

    def test_7_a_new_console_is_found_by_the_page_and_wants_its_own_token(self):
        self.console.kill()
        self.console.wait()
        address = self.start_console(re.search(r":(\d+)/", self.address).group(1))
        self.assertEqual(address.partition("#")[0], self.address.partition("#")[0])
        self.loop.run_until_complete(self.browser.call("Page.bringToFront"))  # a hidden page draws nothing
        self.shows("document.querySelector('#banner').hidden && yarmConsole.pictures() > 0")
        self.page("document.querySelector('#stop').click()")
        self.shows("document.querySelector('#answer').textContent.includes('the token is wrong')")
        self.shows("!document.querySelector('#token-form').hidden")
        self.assertFalse(self.safety.latched)
        token = address.partition("#token=")[2]
        self.page(f"document.querySelector('#token').value = '{token}'")
        self.page("document.querySelector('#token-form').requestSubmit()")
        self.shows("document.querySelector('#answer').textContent === 'the token is right'")
        self.shows("document.querySelector('#stop-state').textContent === 'everything may move'")
        for state in ("CLEANUP", "IDLE"):
            self.press(state)
        self.shows("yarmConsole.film().last_s > yarmConsole.film().first_s")
        self.page("document.querySelector('#step-back').click()")
        self.shows("yarmConsole.watching() === 'film'")
        self.page("document.querySelector('#stop').click()")
        self.wait(lambda: self.safety.latched, "the monitor's word, while the page looks back")

    def test_8_the_mission_that_its_buttons_drove_has_a_proof_sheet_on_the_page(self):
        self.wait(lambda: list(RESULTS.glob("by_hand/console/*/proof.html")), "proof sheet of the mission")
        (sheet,) = RESULTS.glob("by_hand/console/*/proof.html")
        text = sheet.read_text(encoding="utf-8")
        self.assertRegex(text, f"Target {TARGET}: reached")
        self.assertRegex(text, "hash of all decisions</td><td>[0-9a-f]{64}<")
        self.page("document.querySelector('#tab-results').click()")
        run = f"document.querySelector('[data-run=\"by_hand/console/{sheet.parent.name}\"]')"
        self.shows(f"((button) => button && (button.click(), true))({run})")
        self.shows("[...document.querySelectorAll('#run a')].some((link) => link.textContent === 'proof sheet')")

    def test_9_supervised_it_comes_back_at_its_address_with_its_token(self):
        """At a port that was a free one; the page goes on as if nothing had been."""
        self.console.kill()
        self.console.wait()
        self.address = self.start_console(0, (SCRIPTS / "supervise", SCRIPTS / "console"))
        self.loop.run_until_complete(self.browser.open(self.address))
        self.shows("window.yarmConsole && yarmConsole.pictures() > 1 && document.querySelector('#banner').hidden")
        (first,) = psutil.Process(self.console.pid).children()
        first.kill()
        self.shows("document.querySelector('#banner').textContent.includes('no connection to the console')")
        self.loop.run_until_complete(self.browser.call("Page.bringToFront"))
        self.shows("document.querySelector('#banner').hidden && yarmConsole.pictures() > 1")
        (second,) = psutil.Process(self.console.pid).children()
        self.assertNotEqual(first.pid, second.pid)
        self.assertTrue(self.safety.latched)
        self.page("document.querySelector('#release').click()")
        self.shows("!document.querySelector('#confirm').hidden")
        self.page("document.querySelector('#confirm').click()")
        self.wait(lambda: not self.safety.latched, "the release")
        self.assertTrue(self.page("document.querySelector('#token-form').hidden"))


if __name__ == "__main__":
    init_node("console_test")
    rostest.rosrun("yarm", "console_test", ConsoleTest, sys.argv)
