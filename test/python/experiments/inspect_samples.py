"""Rounds in a layout of four boxes, run once for all tests of a process, and records that are put together by hand."""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import Mapping, Optional, Sequence, Tuple

from yarm.experiments.inspect.eyes import boxes_of
from yarm.experiments.inspect.record import RoundInfo, RoundRecord, RoundRecorder, TouchRow
from yarm.experiments.inspect.runner import run_round
from yarm.geometry import Pose2
from yarm.inspection.model import UNSEEN, Drive, Look, Outcome, Reading, Spin, Stage, Stand, Step, Verdict
from yarm.sim.scenes.layout import Layout
from yarm.sim.scenes.layout_maker import make_layout


def only(layout: Layout, numbers: Sequence[int]) -> Layout:
    """The layout with some of its boxes."""
    kept = [layout.boxes[number - 1] for number in numbers]
    walls = [block for block in layout.arena.blocks if block.kind != "box"]
    arena = dataclasses.replace(layout.arena, blocks=(*walls, *kept))
    return Layout(arena, tuple(layout.tags[number - 1] for number in numbers))


SMALL = only(make_layout("open", 0), (3, 7, 8, 9))


@lru_cache(maxsize=1)
def ours() -> RoundRecord:
    """Ours, seed 1."""
    return run_round(SMALL, "yarm", 1)


@lru_cache(maxsize=1)
def report() -> RoundRecord:
    """The report's, seed 1."""
    return run_round(SMALL, "report", 1)


@lru_cache(maxsize=1)
def printed() -> RoundRecord:
    """The printed program's, seed 1."""
    return run_round(SMALL, "report_printed", 1)


def told(layout: Layout, controller: str, read: Mapping[int, int], home: Optional[Pose2] = None) -> RoundRecord:
    """A round put together by hand: a second of driving, of turning, of looking, and the verdicts that are given.

    Args:
        layout: of the boxes.
        controller: who drove it.
        read: tag of each box that has a verdict, in visiting order.
        home: where it ends; where it began unless given.
    """
    start, recorder = layout.start, RoundRecorder()
    steps: Sequence[Tuple[Step, Pose2]] = (
        (Step(Drive(Pose2(1.0, 0.0), 9.0), Stage.DRIVE, 1), start.compose(Pose2(0.3, 0.0))),
        (Step(Spin(1.0, 1.0), Stage.LOCALISE, 1), start.compose(Pose2(0.3, 0.0, 1.0))),
        (Step(Look(1, 5, 2.0), Stage.LOOK, 1), start.compose(Pose2(0.3, 0.0, 1.0))),
        (Step(Drive(start, 9.0), Stage.HOME), home or start),
    )
    at = start
    for second, (step, after) in enumerate(steps):
        failed = second == 3
        before = (Outcome.FAILED, "blocked") if failed else (Outcome.DONE, "")
        recorder.stepped(float(second), step, *before)
        recorder.passed(float(second), at, at.compose(Pose2(0.02, 0.0)))
        at = after
    recorder.stepped(4.0, Step(Stand(), Stage.DONE), Outcome.DONE, "")
    recorder.passed(4.0, at, None)
    recorder.touched(TouchRow(0.5, "box_1", 0.1, 0.2))
    boxes = {box.number: box for box in boxes_of(layout)}
    verdicts = []
    for number, tag in read.items():
        again = tag > 0 and any(verdict.reading.tag == tag for verdict in verdicts)
        reason = "in doubt" if tag == UNSEEN else ""
        verdicts.append(Verdict(number, boxes[number].pose, Reading(tag, 0.9), again, reason, 2.5))
    info = RoundInfo(layout.arena.name, controller, 0, "kinematic", 480.0, "sift")
    truth = dict(enumerate(layout.tags, start=1))
    return recorder.finish(info, (4.0, Stage.DONE, ""), tuple(boxes.values()), truth, tuple(verdicts), 0.25)
