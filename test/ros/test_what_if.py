"""The service commander/what_if without a cell beside it: a map is forked by a process of its own, and answered."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Tuple

import numpy as np
from yarm.srv import WhatIfRequest

from yarm.commander.params import CommanderParams
from yarm.experiments.what_if.cell import cell_of_case
from yarm.experiments.what_if.world import Fork
from yarm.ros.commander.what_if import answered
from yarm.ros.common.priority import SESSION


def priority() -> Tuple[int, str]:
    """Nice value of this process, and what there is of its session's."""
    return os.getpriority(os.PRIO_PROCESS, 0), SESSION.read_text() if SESSION.exists() else ""


def test_a_map_is_forked_and_answered_and_a_faulty_question_is_refused_at_once() -> None:
    cell = replace(cell_of_case("single"), scene="")
    cell_map = Fork(cell, CommanderParams(), 0.0, np.random.default_rng(0))._map()
    before = priority()
    answer = answered(WhatIfRequest(runs=1, seed=1), cell_map, (), CommanderParams())
    assert answer.success, answer.message
    assert priority() == before, "the forks' priority is none of the Commander's"
    (one,) = answer.answers
    assert (one.name, one.runs, one.cleared, list(one.reasons)) == ("as it is", 1, 1, [])
    assert 3.0 < one.clear_p50_s < 60.0 and one.least_clearance_m > 0.05
    assert "as it is" in answer.message
    wrong = answered(WhatIfRequest(["particles=1", "robots=9"], 500, 1), cell_map, (), CommanderParams())
    assert not wrong.success and "must be within 1 to 200" in wrong.message
    nothing = answered(WhatIfRequest(), None, (), CommanderParams())
    assert "nothing is known of the cell" in nothing.message
