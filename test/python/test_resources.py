"""Data files are found in a checkout and in an install space."""

from __future__ import annotations

from pathlib import Path

import pytest

from yarm import resources

ROOT = Path(__file__).resolve().parents[2]


def test_in_a_checkout_the_package_is_its_root() -> None:
    assert resources.package_root() == ROOT
    assert resources.resource("scenes", "cell", "1m1ma.yaml").is_file()


@pytest.fixture(name="install")
def install_fixture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An install space whose copy of the module is the one asked."""
    share = tmp_path / "install" / "share" / "yarm"
    share.mkdir(parents=True)
    (share / "package.xml").write_text("<package/>")
    module = tmp_path / "install" / "lib" / "python3" / "dist-packages" / "yarm" / "resources.py"
    monkeypatch.setattr(resources, "__file__", str(module))
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    return share


def test_in_an_install_space_it_is_the_share_folder(install: Path) -> None:
    assert resources.package_root() == install


def test_the_prefix_path_is_looked_at_too(install: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resources, "__file__", str(tmp_path / "elsewhere" / "a" / "b" / "yarm" / "resources.py"))
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path / 'nothing'}:{install.parents[1]}")
    assert resources.package_root() == install


def test_nowhere_is_said_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(resources, "__file__", str(tmp_path / "a" / "b" / "yarm" / "resources.py"))
    monkeypatch.setenv("CMAKE_PREFIX_PATH", "")
    with pytest.raises(FileNotFoundError, match=r"no package.xml of yarm above .*setup\.bash"):
        resources.package_root()
