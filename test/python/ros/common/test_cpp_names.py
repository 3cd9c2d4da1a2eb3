"""The C++ names are the Python names."""

from __future__ import annotations

import re
from pathlib import Path

from yarm.ros.common import names

HEADER = Path(__file__).resolve().parents[4] / "include" / "yarm" / "ros" / "names.hpp"


def cpp_names() -> dict:
    return dict(re.findall(r'constexpr char (\w+)\[\] = "([^"]*)"', HEADER.read_text()))


def test_every_cpp_name_is_the_python_name() -> None:
    found = cpp_names()
    assert len(found) >= 12
    assert found == {name: getattr(names, name) for name in found}


def test_camera_names_are_built_alike() -> None:
    text = re.sub(r"\s+", " ", HEADER.read_text())
    builders = re.findall(r'return "([^"]*)" \+ std::to_string\(camera\) \+ "([^"]*)"', text)
    assert [before + "3" + after for before, after in builders] == [
        names.camera_points(3),
        names.camera_optical_frame(3),
    ]
