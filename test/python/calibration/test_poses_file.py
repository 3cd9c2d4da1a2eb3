"""What is written is read; what is faulty is refused with every fault."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.calibration.poses_file import read_poses, write_poses
from yarm.sim.sensors.camera_model import overhead_poses
from yarm.yaml_fields import SceneError


def test_what_is_written_is_read(tmp_path):
    poses = {f"camera_{i}": pose for i, pose in enumerate(overhead_poses())}
    write_poses(tmp_path / "cameras.yaml", poses, "By hand.\nTwo lines.")
    assert (tmp_path / "cameras.yaml").read_text().startswith("# By hand.\n# Two lines.\ncameras:\n")
    read = read_poses(tmp_path / "cameras.yaml")
    assert list(read) == list(poses)
    for frame, pose in poses.items():
        assert np.allclose(read[frame], pose, atol=2e-6)


def test_every_fault_is_named(tmp_path):
    (tmp_path / "bad.yaml").write_text(
        "cameras:\n"
        "  - {frame: a, xyz: [0, 0, 99], quaternion: [0, 0, 0, 1]}\n"
        "  - {frame: b, xyz: [0, 0, 2], quaternion: [0, 0, 0, 0.5]}\n"
        "  - {frame: c, xyz: [0, 0, 2], quaternion: [0, 0, 0, 1], colour: red}\n"
        "  - {frame: c, xyz: [0, 0, 2], quaternion: [0, 0, 0, 1]}\n"
    )
    with pytest.raises(SceneError) as caught:
        read_poses(tmp_path / "bad.yaml")
    said = str(caught.value)
    for expected in ("bad.yaml", "xyz", "x, y, z, w of length 1, not 0.500", "colour", "each frame once"):
        assert expected in said
