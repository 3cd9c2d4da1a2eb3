"""The pictures of docs/planning.md are drawn by the code they explain."""

from __future__ import annotations

import re
from pathlib import Path

from yarm.planning.tools.pictures import draw_pictures
from yarm.resources import package_root


def test_every_picture_of_the_page_is_drawn(tmp_path: Path) -> None:
    page = (package_root() / "docs" / "planning.md").read_text(encoding="utf-8")
    wanted = set(re.findall(r"\(images/(planning_\w+\.png)\)", page))
    draw_pictures(tmp_path)
    assert len(wanted) >= 5 and wanted <= {path.name for path in tmp_path.glob("*.png")}
    assert all(path.stat().st_size > 5000 for path in tmp_path.glob("*.png"))
