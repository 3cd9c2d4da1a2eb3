"""The file that calibrate_cameras writes and real_cell.launch reads: where cameras' frames are in the world."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Dict, Mapping

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from yarm.geometry import FloatArray, transform_matrix
from yarm.yaml_fields import Faults, Fields, load_yaml

MOST_CAMERAS = 32
REACH_M = 50.0
LENGTH_TOLERANCE = 0.01
"""Of a quaternion, from 1."""


def write_poses(path: Path, poses: Mapping[str, FloatArray], comment: str) -> None:
    """Write T_world_frame (4, 4) of each frame; ``comment`` says how they were found.

    Raises:
        OSError: it cannot be written.
    """
    cameras = []
    for frame, pose in poses.items():
        xyz = [round(float(v), 6) for v in pose[:3, 3]]
        quaternion = [round(float(v), 8) for v in Rotation.from_matrix(pose[:3, :3]).as_quat()]
        cameras.append({"frame": frame, "xyz": xyz, "quaternion": quaternion})
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    path.write_text(head + yaml.safe_dump({"cameras": cameras}, sort_keys=False, width=160, default_flow_style=None))


def read_poses(path: Path) -> Dict[str, FloatArray]:
    """T_world_frame (4, 4) of each frame.

    Raises:
        SceneError: faults, all listed.
    """
    faults = Faults(str(path))
    top = Fields(load_yaml(path), "", faults)
    poses: Dict[str, FloatArray] = {}
    for fields in top.entries("cameras", MOST_CAMERAS):
        frame = fields.text("frame")
        xyz = fields.numbers("xyz", 3, -REACH_M, REACH_M)
        quaternion = fields.numbers("quaternion", 4, -1.0, 1.0)
        fields.finish()
        if len(xyz) == 3 and len(quaternion) == 4:
            length = math.sqrt(sum(v * v for v in quaternion))
            if abs(length - 1.0) > LENGTH_TOLERANCE:
                faults.add(fields.path("quaternion"), list(quaternion), f"x, y, z, w of length 1, not {length:.3f}")
            elif frame in poses:
                faults.add(fields.path("frame"), frame, "each frame once")
            else:
                poses[frame] = transform_matrix(xyz, np.asarray(quaternion) / length)
    top.finish()
    faults.raise_if_any()
    return poses
