"""Looks from one place are one opinion, other places further ones."""

from __future__ import annotations

import math
from typing import Dict

import pytest

from yarm.geometry import Pose2
from yarm.tags.calibration import BLANK, UNKNOWN
from yarm.tags.evidence import ACCEPTING, BoxEvidence
from yarm.tags.recogniser import Finding, Look, Status


def opinion(finding: Finding = Finding.IN_PLACE, **shares: float) -> Look:
    """A look with probabilities, as tag_3=0.7, blank=0.2, unknown=0.1."""
    answers: Dict[str, int] = {"blank": BLANK, "unknown": UNKNOWN}
    return Look(
        Status.LOOKED,
        probabilities={answers.get(name, int(name[4:]) if name[4:].isdigit() else 0): p for name, p in shares.items()},
        finding=finding,
    )


SURE = opinion(tag_3=0.9995, blank=0.0003, unknown=0.0002)
HALF = opinion(tag_3=0.7, blank=0.2, unknown=0.1)
AGAINST = opinion(tag_3=0.2, blank=0.2, unknown=0.6)


def test_one_sure_look_is_final() -> None:
    evidence = BoxEvidence(2)
    evidence.add(SURE, Pose2(0, 0))
    verdict = evidence.verdict()
    assert (verdict.box, verdict.answer, verdict.text, verdict.final, verdict.reason) == (2, 3, "3", True, "")
    assert verdict.probability >= ACCEPTING
    assert sum(verdict.scores.values()) == pytest.approx(1.0)


def test_the_same_place_is_within_ten_centimetres_and_ten_degrees() -> None:
    for robot, places in (
        (Pose2(0.09, 0.0), 1),
        (Pose2(0.11, 0.0), 2),
        (Pose2(0.0, 0.0, math.radians(9.0)), 1),
        (Pose2(0.0, 0.0, math.radians(-11.0)), 2),
    ):
        evidence = BoxEvidence(1)
        evidence.add(HALF, Pose2(0, 0))
        evidence.add(HALF, robot)
        assert evidence.verdict().places == places


def test_another_place_makes_it_surer_or_takes_it_back() -> None:
    evidence = BoxEvidence(1)
    evidence.add(HALF, Pose2(0, 0))
    first = evidence.verdict().probability
    evidence.add(HALF, Pose2(1, 0))
    assert evidence.verdict().probability > first
    evidence.add(AGAINST, Pose2(2, 0))
    evidence.add(AGAINST, Pose2(3, 0))
    evidence.add(AGAINST, Pose2(4, 0))
    assert evidence.verdict().probability < first


def test_no_single_place_is_beyond_doubt() -> None:
    evidence = BoxEvidence(1)
    evidence.add(opinion(tag_3=1.0, blank=0.0, unknown=0.0), Pose2(0, 0))
    for x in (1.0, 2.0, 3.0):
        evidence.add(opinion(tag_3=0.001, blank=0.001, unknown=0.998), Pose2(x, 0))
    assert evidence.verdict().answer == UNKNOWN


def test_the_latest_finding_counts_and_unusable_looks_leave_it() -> None:
    evidence = BoxEvidence(1)
    evidence.add(opinion(Finding.MOVED, tag_3=0.9, blank=0.05, unknown=0.05), Pose2(0, 0))
    evidence.add(Look(Status.DARK, "grey 3"), Pose2(1, 0))
    verdict = evidence.verdict()
    assert (verdict.finding, verdict.images, verdict.places) == (Finding.MOVED, 2, 1)


def test_without_an_answer_the_reason_is_that_of_the_last_look() -> None:
    evidence = BoxEvidence(1)
    evidence.add(Look(Status.LOOKED, "nothing stands where the box must be", finding=Finding.MISSING), Pose2(0, 0))
    verdict = evidence.verdict()
    assert (verdict.text, verdict.finding, verdict.final) == ("none", Finding.MISSING, False)
    assert verdict.reason == "nothing stands where the box must be"
