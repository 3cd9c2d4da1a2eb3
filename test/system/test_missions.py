"""Whole missions in full physics with perception in the loop, each in a ROS of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.launched import rostest_command, run

FILES = sorted(Path(__file__).parent.glob("*.test"))
LIMIT_S = 1200.0


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_mission(file):
    run(rostest_command(file), f"mission_{file.stem}", LIMIT_S)
