"""What the inspector draws, says and writes: markers by verdict, verdict messages, the result file, its parameters."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
import rospy

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.executor import Action
from yarm.inspection.model import BLANK, UNKNOWN, UNSEEN, Reading, Verdict
from yarm.inspection.session import SessionStep
from yarm.inspection.viewpoints import viewpoint
from yarm.params import ParamError
from yarm.resources import resource
from yarm.ros.inspection.drawing import (
    EMPTY,
    NAMED,
    NO_VERDICT,
    NOT_YET,
    NOW,
    STRANGE,
    box_markers,
    state_marker,
    verdict_words,
    way_markers,
)
from yarm.ros.inspection.outputs import write_whole
from yarm.ros.inspection.params import inspector_params
from yarm.ros.inspection.verdicts import box_verdict, free_verdict
from yarm.tags.evidence import TagVerdict as Evidence
from yarm.tags.free_look import FreeLook
from yarm.tags.pictures import stranger
from yarm.tags.recogniser import Finding

BOX = Box(3, Pose2(1.0, 2.0, math.pi / 2))
PRACTICE = resource("scenes", "inspection", "practice_boxes.yaml")


def verdict(tag, probability=0.9999, **more):
    return Verdict(3, BOX.pose, Reading(tag, probability), **more)


@pytest.mark.parametrize(
    ("found", "now", "color"),
    [
        (None, 0, NOT_YET),
        (None, 3, NOW),
        (verdict(5), 3, NAMED),
        (verdict(BLANK), 0, EMPTY),
        (verdict(UNKNOWN), 0, STRANGE),
        (verdict(UNSEEN, 0.0), 0, NO_VERDICT),
    ],
)
def test_a_box_has_the_colour_of_its_verdict_and_lies_as_it_is_given(found, now, color):
    solid, _, words = box_markers([BOX], {} if found is None else {3: found}, now, 0.4)
    assert (solid.color.r, solid.color.g, solid.color.b, solid.color.a) == color
    assert (solid.scale.x, solid.scale.y, solid.scale.z) == pytest.approx((0.16, 0.5, 0.4))
    turn = 2.0 * math.atan2(solid.pose.orientation.z, solid.pose.orientation.w)
    assert turn == pytest.approx(math.pi / 2) and words.text.startswith("3")


def test_words_of_a_verdict():
    assert verdict_words(verdict(5, duplicate=True)) == "tag 5 (duplicate) 1.000"
    assert verdict_words(verdict(UNSEEN, 0.0)) == "no verdict"
    assert verdict_words(Verdict(3, BOX.pose, Reading(7, 0.5, note="upside down"))) == "tag 7 0.500\nupside down"


def test_the_tour_goes_from_the_robot_through_the_viewpoints_home():
    here, home, view = Pose2(0.0, 0.0), Pose2(-1.0, 0.0), viewpoint(BOX, 0.5, 0.0)
    made = way_markers(here, home, [view])
    (line,) = (marker for marker in made if marker.ns == "tour")
    stops = np.array([(point.x, point.y) for point in line.points])
    assert np.allclose(stops, [(0, 0), (view.pose.x, view.pose.y), (-1, 0)])
    assert {marker.ns for marker in made} == {"viewpoints", "home", "tour"}
    assert way_markers(None, None, []) == []


def test_the_robot_bears_stage_and_times():
    step = SessionStep("drive", 3, 60.0, 125.0, 17.2, "scan: gone", (), Action())
    text = state_marker(step, 2, 10, "base_footprint").text
    assert text == "drive box 3: 2 of 10 boxes\n2:05 left, 17 s home\nscan: gone"


def test_a_verdict_carries_its_evidence():
    evidence = Evidence(3, 5, 0.9, {5: 0.9, 1: 0.05, -1: 0.02, 0: 0.03}, Finding.MOVED, Pose2(1.2, 2.0, 1.5), 4, 2, "")
    message = box_verdict(verdict(5, 0.9, reason="in doubt"), evidence, rospy.Time(7), "map")
    assert (message.box, message.tag, message.probability, message.reason) == (3, 5, 0.9, "in doubt")
    assert list(message.answers) == [1, 5, 0, -1] and list(message.scores) == [0.05, 0.9, 0.03, 0.02]
    assert message.has_pose and message.pose.position.x == 1.2
    assert (message.finding, message.images, message.places, message.header.frame_id) == ("moved", 4, 2, "map")
    bare = box_verdict(verdict(BLANK), None, rospy.Time(7), "map")
    assert not bare.has_pose and not bare.scores and bare.finding == "not seen"


def test_a_picture_of_nothing_known_says_so():
    message = free_verdict(FreeLook(reason="no tag"))
    assert (message.box, message.tag, message.reason, list(message.scores)) == (0, UNSEEN, "no tag", [])
    message = free_verdict(FreeLook(probabilities={4: 0.8, 0: 0.1, -1: 0.1}))
    assert message.tag == 4 and "final from" in message.reason


def test_a_file_is_replaced_as_a_whole(tmp_path):
    path = tmp_path / "result.txt"
    write_whole(path, "one\n")
    write_whole(path, "two\n")
    assert path.read_text() == "two\n" and [file.name for file in tmp_path.iterdir()] == ["result.txt"]


def test_parameters_and_files_are_read_together(tmp_path):
    given = inspector_params(
        {"result": str(tmp_path / "new" / "r.txt"), "report": {"images": 3}}, PRACTICE, "/inspector"
    )
    assert len(given.boxes) == 10 and len(given.tags) == 15 and given.report.images == 3
    assert given.params.round.time_limit_s == 480.0 and (tmp_path / "new").is_dir()


def test_the_detector_is_the_report_s_choice_and_never_ours(tmp_path):
    for controller, detector in (("yarm", "sift"), ("report", "orb"), ("report_printed", "orb")):
        values = {"controller": controller, "result": str(tmp_path / "r.txt"), "report": {"detector": "orb"}}
        assert inspector_params(values, PRACTICE, "/inspector").detector == detector
    usual = {"controller": "report", "result": str(tmp_path / "r.txt")}
    assert inspector_params(usual, PRACTICE, "/inspector").detector == "sift"


def test_a_detector_that_the_build_does_not_have_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("yarm.tags.features._surf", lambda: None)
    for name in ("surf", "harris"):
        values = {"result": str(tmp_path / "r.txt"), "report": {"detector": name}}
        with pytest.raises(ParamError, match=f"report.detector = '{name}': the installed OpenCV has sift, orb, akaze"):
            inspector_params(values, PRACTICE, "/inspector")


def test_two_tags_with_one_picture_are_refused_by_numbers_and_files(tmp_path):
    for name, number in (("one.png", 0), ("two.png", 1), ("again.png", 0)):
        cv2.imwrite(str(tmp_path / name), stranger(number))
    listed = tmp_path / "tags.yaml"
    files = {1: "one.png", 2: "two.png", 5: "again.png"}
    listed.write_text("tags:\n" + "".join(f"- {{number: {n}, file: {file}}}\n" for n, file in files.items()))
    with pytest.raises(ParamError, match=r"tags 1 and 5 \(one.png, again.png\) show the same picture.*leave one out"):
        inspector_params({"tags": str(listed), "result": str(tmp_path / "r.txt")}, PRACTICE, "/inspector")


def test_everything_that_is_wrong_is_told_at_once(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    values = {
        "controller": "nobody",
        "speed": 1.0,
        "boxes": "/nowhere/boxes.yaml",
        "tags": "/nowhere/tags.yaml",
        "result": str(file / "r.txt"),
        "report": {"tries": 0},
    }
    with pytest.raises(ParamError) as caught:
        inspector_params(values, PRACTICE, "/inspector")
    for words in (
        "controller = 'nobody'",
        "speed: unknown",
        "/nowhere/boxes.yaml",
        "/nowhere/tags.yaml",
        "report.tries",
    ):
        assert words in str(caught.value)
    with pytest.raises(ParamError, match="cannot be made"):
        inspector_params({"result": str(file / "r.txt")}, PRACTICE, "/inspector")
