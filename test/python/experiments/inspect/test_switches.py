"""Each known fault shows in the report's round when it is switched on."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List

from python.experiments.inspect_samples import only
from yarm.experiments.inspect.eyes import Camera, boxes_of, make_eyes
from yarm.experiments.inspect.measures import measure
from yarm.experiments.inspect.pilot import known_map
from yarm.experiments.inspect.record import LookRecord, RoundRecord
from yarm.experiments.inspect.runner import run_round
from yarm.experiments.inspect.switched_eyes import StricterRecogniser, with_strangers
from yarm.experiments.inspect.switches import Switches
from yarm.geometry import Pose2
from yarm.inspection.model import BLANK, PRINTED, UNKNOWN, UNSEEN, Stage
from yarm.inspection.printed_round import PAUSE_S
from yarm.sim.scenes.arena import Arena, Block
from yarm.sim.scenes.layout import Layout, walls
from yarm.sim.scenes.layout_maker import make_layout
from yarm.tags.pictures import shipped_pictures

REMEDIED = Switches(large_only=True, inliers_used=True)
ONE = only(make_layout("corridor", 0), (3,))


def turns_at_the_box(record: RoundRecord) -> List[float]:
    """How far the robot turned between the looks at the box, rad."""
    yaws = [row.true_yaw for row in record.path if row.doing == "look"]
    return [abs(math.remainder(b - a, 2.0 * math.pi)) for a, b in zip(yaws, yaws[1:]) if a != b]


def test_loose_headings_sleeps_and_the_printed_vote() -> None:
    plain = run_round(ONE, "report", 1)
    faulty = run_round(ONE, "report", 1, Switches(loose_heading=True, sleeps=True, printed_vote=True))
    assert max(turns_at_the_box(plain)) > 0.05 and max(turns_at_the_box(faulty), default=0.0) < 0.02
    looked, asleep = measure(plain).looking_s, measure(faulty).looking_s
    images = len(plain.looks)
    assert images == 21 == len(faulty.looks) and abs(asleep - looked - images * PAUSE_S) < 0.11 * 3
    whole = max(seen.keypoints for look in faulty.looks for seen in look.sightings)
    assert whole > max(seen.keypoints for look in plain.looks for seen in look.sightings)


def test_lost_frames_are_votes_for_every_tag_in_the_printed_program_alone() -> None:
    text = run_round(ONE, "report", 1, Switches(frames_lost=True))
    printed = run_round(ONE, "report", 1, Switches(frames_lost=True, printed_vote=True))
    assert len(text.looks) == 14 == len(printed.looks)
    blank = replace(ONE, tags=(BLANK,) * len(ONE.tags))
    seen = run_round(blank, "report", 1, Switches(frames_lost=True)).verdicts
    assert [verdict.reading.tag for verdict in seen] == [BLANK]
    named = run_round(blank, "report", 1, Switches(frames_lost=True, printed_vote=True)).verdicts
    assert [verdict.reading.tag for verdict in named] == [UNSEEN], "7 images that did not come are 105 votes: not blank"


def test_copied_frames_are_one_picture_a_heading_and_whole_images_hold_more_keypoints() -> None:
    seven = run_round(ONE, "report", 1, Switches(frames_copied=True)).looks
    assert len(seven) == 21 and len({look.sightings[0].good for look in seven}) <= 3
    plain, whole = (run_round(ONE, "report", 1, s).looks for s in (Switches(), Switches(whole_images=True)))
    most = [max(seen.keypoints for look in looks for seen in look.sightings) for looks in (plain, whole)]
    assert most[1] > most[0]


def test_a_strangers_tag_hangs_on_every_third_box_that_bears_one() -> None:
    layout = make_layout("open", 0)
    strange = with_strangers(layout)
    changed = [i for i, (a, b) in enumerate(zip(layout.tags, strange.tags)) if a != b]
    tagged = [i for i, tag in enumerate(layout.tags) if tag != BLANK]
    assert changed == tagged[2::3] and {strange.tags[i] for i in changed} == {UNKNOWN}
    record = run_round(replace(ONE, tags=(UNKNOWN,)), "report", 1)
    assert record.truth == {1: UNKNOWN} and measure(record).right == 0
    assert [verdict.reading.tag for verdict in record.verdicts] == [BLANK], "it knows no unknown tag"


def test_small_outlines_and_those_that_few_matches_agree_with_do_not_count() -> None:
    plain = run_round(ONE, "report", 1)
    assert measure(plain).right == 1 == measure(run_round(ONE, "report", 1, REMEDIED)).right
    tags = shipped_pictures()
    picture, number = Camera(ONE, 1).picture(plain.looks[0].robot), ONE.tags[0]
    rejections = []
    for least_px2, least_inliers in ((0.0, 0), (1e6, 0), (0.0, 10), (0.0, 10_000)):
        seen = StricterRecogniser(tags, least_px2, least_inliers).look(picture)
        rejections.append(next(s.rejection for s in seen if s.tag == number))
    assert rejections == ["", "no homography", "", "no homography"]
    assert StricterRecogniser({number: tags[number]}, 1e6, 10_000).look(None)[0].rejection == "no image"


def facing_a_back() -> Layout:
    """Box 1 looks at the back of box 2, which stands where it would be seen from straight ahead at 0.5 m."""
    size = (0.16, 0.5, 0.4)
    boxes = [Block(f"box_{i + 1}", "box", Pose2(0.55 * i, 0.0), size) for i in range(2)]
    lower, upper = (-2.0, -2.0), (2.0, 2.0)
    arena = Arena("two", "custom", 0, lower, upper, (*walls(lower, upper), *boxes), Pose2(-1.0, -1.0))
    return Layout(arena, (7, 3))


def test_a_map_without_boxes_lets_the_robot_choose_what_it_cannot_reach() -> None:
    layout = facing_a_back()
    grid = known_map(layout.arena, boxes=False)
    assert {int(grid.cells[grid.cell_of(box.pose.x, box.pose.y)]) for box in boxes_of(layout)} == {0}
    seeing = measure(run_round(layout, "report", 1))
    blind = run_round(layout, "report", 1, Switches(empty_map=True, no_neighbours=True))
    assert seeing.goals_failed == 0 and measure(blind).goals_failed == 2
    assert [verdict.box for verdict in blind.verdicts if "was not reached" in verdict.reason] == [1]
    careless = run_round(layout, "report", 1, Switches(empty_map=True, no_neighbours=True, goals_ignored=True))
    assert sum(look.box == 1 for look in careless.looks) == 21, "pictures of something else are filed under this box"


def test_no_image_is_blank_for_the_printed_vote() -> None:
    kept: List[LookRecord] = []
    assert make_eyes(PRINTED, ONE, Camera(ONE, 1), kept.append).reading(1).tag == BLANK


def test_the_whole_printed_program_in_one_round() -> None:
    record = run_round(ONE, PRINTED, 1)
    assert len(record.looks) == 21 and all(look.printed for look in record.looks)
    assert record.stage == Stage.DONE and len(record.verdicts) == 1
    assert max(turns_at_the_box(record)) < 0.098, "its headings are nearer to each other than the text's"
