"""Every rostest of this folder, each in a ROS of its own."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.launched import LaunchedTestError, rostest_command, run

FILES = sorted(Path(__file__).parent.glob("*.test"))
LIMIT_S = 900.0


@pytest.mark.parametrize("file", FILES, ids=[file.stem for file in FILES])
def test_rostest(file):
    output = run(rostest_command(file), file.stem, LIMIT_S)
    assert re.search(r"TESTS: [1-9]", output), f"{file.stem}: its launch ended before any test: {output[-2000:]}"


def test_a_failing_rostest_is_noticed(tmp_path):
    bad = tmp_path / "bad.test"
    bad.write_text('<launch><test test-name="bad" pkg="yarm" type="no_such_test.py"/></launch>')
    with pytest.raises(LaunchedTestError, match="no_such_test"):
        run(rostest_command(bad), "bad", LIMIT_S)
