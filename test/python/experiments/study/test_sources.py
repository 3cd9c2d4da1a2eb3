"""Which files a module depends on."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, List

import pytest

from yarm.experiments.study.sources import files_of

FILES: Dict[str, str] = {
    "__init__.py": "",
    "a.py": "import os\nfrom pack.inner.b import f\n",
    "lonely.py": "",
    "late.py": "",
    "inner/__init__.py": "import pack.shared\n",
    "inner/b.py": "def f():\n    from pack import late\n    return late\n",
    "inner/c.py": "from pack.inner import b\nfrom pack import a\n",
    "shared.py": "from pack import a\n",
}


@pytest.fixture()
def package(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        file = tmp_path / "pack" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path / "pack"


def names(files: List[Path], package: Path) -> List[str]:
    return [str(file.relative_to(package)) for file in files]


def test_imports_are_followed_wherever_they_stand_with_their_packages(package: Path) -> None:
    found = names(files_of(["pack.a"], package=package), package)
    assert found == ["__init__.py", "a.py", "inner/__init__.py", "inner/b.py", "late.py", "shared.py"]


def test_what_is_left_out_is_not_followed(package: Path) -> None:
    found = names(files_of(["pack.inner.c"], {"pack.inner.b"}, package), package)
    assert found == ["__init__.py", "a.py", "inner/__init__.py", "inner/c.py", "shared.py"]


def test_a_module_that_is_not_there_is_named(package: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"pack\.gone"):
        files_of(["pack.gone"], package=package)
