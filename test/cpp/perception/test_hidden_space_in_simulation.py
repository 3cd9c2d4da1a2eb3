"""Nothing that walked in unseen and stands where no camera sees is driven into; goals stay reachable. Noise on."""

from __future__ import annotations

import pytest

from support.hidden_truth import Tally, run_trial
from yarm.planning.model.hidden import HiddenPolicy

GOALS = 3


@pytest.mark.parametrize("fenced", [False, True])
@pytest.mark.parametrize("seed", [15])
def test_what_stands_where_two_of_four_cameras_do_not_see_it_is_not_driven_into(seed, fenced):
    tally = Tally()
    run_trial(seed, silent=2, goals=GOALS, tally=tally, fenced=fenced)
    free, known = tally.counts[HiddenPolicy.FREE], tally.counts[HiddenPolicy.KNOWN_BODIES]
    assert free.hidden == known.hidden == 1, f"seed {seed}: nothing was hidden"
    assert free.driven_into == 1, f"seed {seed}: nothing to see: the published way does not lead there either"
    assert known.driven_into == 0, f"seed {seed}"


def test_who_was_seen_on_his_way_to_where_nobody_sees_him_stays_on_the_map():
    tally = Tally()
    run_trial(1, silent=2, goals=GOALS, tally=tally)
    assert tally.counts[HiddenPolicy.FREE].feasible > 0
    assert tally.counts[HiddenPolicy.FREE].hidden == 0, "the map does not show him"


def test_with_all_cameras_every_goal_that_has_a_way_keeps_it():
    tally = Tally()
    run_trial(2, silent=0, goals=GOALS, tally=tally)
    known = tally.counts[HiddenPolicy.KNOWN_BODIES]
    assert known.reached == known.feasible > 0
