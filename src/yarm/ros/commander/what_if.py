"""Service ``commander/what_if``: the live cell's forks, run by ``rosrun yarm what_if`` in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import List, Optional, Sequence

import rospkg
import rospy
from std_msgs.msg import Float32

from yarm.commander.params import CommanderParams
from yarm.experiments.what_if.ask import alternative, specs_of
from yarm.experiments.what_if.cell import COUNTED, Settings, WhatIfError
from yarm.experiments.what_if.live import arms_of, cell_of_map
from yarm.geometry import CellMap
from yarm.msg import WhatIfAnswer
from yarm.records import plain
from yarm.resources import package_root
from yarm.ros.common import names
from yarm.ros.common.stations import load_station
from yarm.srv import WhatIfRequest, WhatIfResponse

LIMIT_S = 600.0
"""Wall time in which the answer must be there, s."""
USUAL_RUNS = 10
PROGRESS_LIMIT_S = 1.0
"""Wall time that a sander has to say how far it is, s."""


def live_settings(params: CommanderParams) -> Settings:
    """What the forks of a Commander take over of its parameters."""
    found = []
    for name in COUNTED:
        value = getattr(params, name)
        found.append((name, json.dumps(list(value)) if isinstance(value, tuple) else str(value)))
    return tuple(found)


def share_done(arms: Sequence[str]) -> float:
    """Share of its raster that the first of the arms has done; negative when it is at none, or there is no arm."""
    if not arms:
        return -1.0
    try:
        told = rospy.wait_for_message(names.sander_progress(min(arms)), Float32, timeout=PROGRESS_LIMIT_S)
    except rospy.ROSException:
        return -1.0
    return min(0.99, float(told.data))


def answered(
    question: WhatIfRequest, cell_map: Optional[CellMap], arms: Sequence[str], params: CommanderParams
) -> WhatIfResponse:
    """Run what is asked for and answer; never raises for a bad question, the message says what is wrong with it."""
    if cell_map is None:
        return WhatIfResponse(message="no planning_metadata yet: nothing is known of the cell")
    cell = cell_of_map(cell_map, {arm: load_station(arm) for arm in arms_of(cell_map)}, live_settings(params))
    try:
        specs_of(cell, [alternative(text) for text in asked_for(question)], question.runs or USUAL_RUNS, 1, {})
    except WhatIfError as error:
        return WhatIfResponse(message=str(error))
    cell = replace(cell, share=share_done(arms))
    with tempfile.TemporaryDirectory(prefix="yarm-what-if-") as folder:
        asked, told = Path(folder) / "cell.json", Path(folder) / "answers.json"
        asked.write_text(json.dumps(plain(cell)))
        call = [*command(), "--cell", str(asked), "--answers", str(told), "--seed", str(question.seed)]
        call += ["--runs", str(question.runs or USUAL_RUNS), "--results", rospkg.get_ros_home()]
        call += [word for text in asked_for(question) for word in ("--alternative", text)]
        try:
            done = subprocess.run(call, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        except subprocess.TimeoutExpired:
            return WhatIfResponse(message=f"no answer within {LIMIT_S:.0f} s: ask for fewer runs")
        if done.returncode != 0 or not told.is_file():
            return WhatIfResponse(message=done.stderr.strip()[-2000:] or "what_if ended without an answer")
        values = json.loads(told.read_text())
    answers: List[WhatIfAnswer] = [
        WhatIfAnswer(**{**one, "reasons": list(one["reasons"])}) for one in values["answers"]
    ]
    return WhatIfResponse(True, values["table"], answers, values["plot"])


def asked_for(question: WhatIfRequest) -> List[str]:
    """The alternatives of a question; without any, the cell as it is."""
    return list(question.alternatives) or [""]


def command() -> List[str]:
    """How ``what_if`` is called: the checkout's own script, or the installed one by rosrun."""
    script = package_root() / "scripts" / "what_if"
    return [sys.executable, str(script)] if script.is_file() else ["rosrun", "yarm", "what_if"]
