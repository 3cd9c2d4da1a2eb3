"""A bag becomes a film: what a page would have shown of the system when it was recorded."""

from __future__ import annotations

import json
import subprocess

import pytest
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from yarm.msg import CommanderStatus, ObjectRegistry, RegisteredObject, SafetyStatus

from support.films import shown, taken
from yarm.console.film import FilmError, unpack
from yarm.console.wire import decode
from yarm.ros.common import names
from yarm.ros.console.bags import film_of_bag
from yarm.ros.console.recorded import recorded

FRAME = names.ee_frame("ankurbot_1")
LENGTH_S, SPEED_MPS = 12.0, 0.25


def at(time_s):
    moved = TransformStamped(child_frame_id=FRAME)
    moved.header.frame_id, moved.header.stamp = "world", rospy.Time.from_sec(time_s)
    moved.transform.translation.x, moved.transform.rotation.w = SPEED_MPS * time_s, 1.0
    return TFMessage([moved])


def write_bag(path, leading="", status=None):
    """A robot that drives along x, from 1 s on."""
    robot = RegisteredObject(name="ankurbot_1", object="Mobile", type="dynamic", seed_frame=FRAME)
    with rosbag.Bag(str(path), "w") as bag:
        bag.write(f"{leading}{names.OBJECT_REGISTRY}", ObjectRegistry(entries=[robot]), rospy.Time(1))
        for i in range(int(30 * LENGTH_S)):
            time_s = 1.0 + i / 30.0
            stamp = rospy.Time.from_sec(time_s)
            bag.write("/tf", at(time_s), stamp)
            if i % 30 == 0:
                said = CommanderStatus(state=3, state_name="MENU", elapsed_s=time_s)
                bag.write(f"{leading}{names.COMMANDER_STATUS}", said, stamp)
                bag.write("/rosout", Log(level=Log.WARN, name="/database", msg=f"no input {i}"), stamp)
            if status is not None:
                bag.write(names.SAFETY_STATUS, status, stamp)
    return path


def pictures(film):
    """Time, header and arrays of every picture."""
    index = film.index()
    entries = [entry for i in range(len(index["blocks"])) for entry in unpack(film.block(index["first"] + i))]
    found = [(time_s, *decode(message)) for time_s, message in entries]
    return [each for each in found if each[1]["kind"] == "state"]


@pytest.mark.parametrize("leading", ["", "/"])
def test_it_shows_where_everything_was_and_what_was_said(tmp_path, leading):
    film = film_of_bag(write_bag(tmp_path / "run.bag", leading), 0.2)
    found = pictures(film)
    assert len(found) == pytest.approx(5 * LENGTH_S, abs=2)
    for time_s, header, arrays in found:
        assert header["time_s"] == pytest.approx(time_s, abs=1e-3)
        assert arrays["poses"][0, 0] == pytest.approx(SPEED_MPS * time_s, abs=SPEED_MPS / 25.0)
        assert header["commander"]["state"] == "MENU"
    assert found[-1][1]["lines"][0]["layer"] == "driven"
    assert len(film.index()["events"]) == int(LENGTH_S)
    assert film.notes == []


def test_what_another_version_has_recorded_is_left_out_and_named(tmp_path):
    film = film_of_bag(write_bag(tmp_path / "run.bag", status=String("a type that safety/status has not")), 0.2)
    assert film.notes == ["recorded with another version of yarm, left out: std_msgs/String"]
    assert pictures(film)[-1][1]["stop"] is None


def test_a_status_of_now_is_taken_in(tmp_path):
    film = film_of_bag(write_bag(tmp_path / "run.bag", status=SafetyStatus(latched=True, reason="pressed")), 0.2)
    assert pictures(film)[-1][1]["stop"] == {"latched": True, "reason": "pressed"}


@pytest.mark.parametrize("content", [b"", b"#ROSBAG V2.0\nnothing", b"no bag at all, but long enough"])
def test_a_bag_that_cannot_be_read_is_refused_by_its_name(tmp_path, content):
    path = tmp_path / "run.bag"
    path.write_bytes(content)
    with pytest.raises(FilmError, match=r"run\.bag cannot be read"):
        film_of_bag(path, 0.2)


def test_an_empty_bag_is_refused(tmp_path):
    with rosbag.Bag(str(tmp_path / "run.bag"), "w"):
        pass
    with pytest.raises(FilmError, match="it has no messages"):
        film_of_bag(tmp_path / "run.bag", 0.2)


def test_a_folder_shows_its_film_or_else_its_bag(tmp_path):
    folder = tmp_path / "results/case/3"
    folder.mkdir(parents=True)
    write_bag(folder / "run.bag")
    found = recorded(folder)
    assert (found.film.title, found.results) == ("case/3", tmp_path / "results")
    assert len(found.film.index()["events"]) == int(LENGTH_S)
    taken(10).write(folder / "run.film")
    assert shown(recorded(folder).film) == shown(taken(10))


def test_a_folder_without_either_is_refused_with_what_was_looked_for(tmp_path):
    with pytest.raises(FilmError, match=r"there is no .*run\.film and .*run\.bag"):
        recorded(tmp_path)


def test_the_command_exports_a_run_without_a_master_and_says_what_is_wrong(tmp_path):
    write_bag(tmp_path / "run.bag")
    (tmp_path / "summary.yaml").write_text("success: true\n")
    call = ["rosrun", "yarm", "console", "--run", str(tmp_path), "--export", str(tmp_path / "run.html")]
    done = subprocess.run(call, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "run.html").read_text()
    brought = json.loads(text.partition('id="offline">')[2].partition("</script>")[0])
    assert brought["run"]["summary"] == {"success": True}
    call[4] = str(tmp_path / "none")
    failed = subprocess.run(call, capture_output=True, text=True, timeout=120, check=False)
    assert failed.returncode == 1
    assert "console: nothing to show: there is no" in failed.stderr
