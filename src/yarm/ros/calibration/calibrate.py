"""Command ``calibrate_cameras``: where the overhead cameras are, from what they see of known bodies at rest."""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import rospy

from yarm.calibration.extrinsics import Refined, calibrated
from yarm.calibration.poses_file import write_poses
from yarm.calibration.watch import correction
from yarm.geometry import FloatArray
from yarm.ros.calibration.params import CameraWatchParams
from yarm.ros.calibration.view import CellView, snapshot
from yarm.ros.common import names
from yarm.ros.common.start import init_command

WAIT_S = 10.0
"""Wall time that the registry, and each cloud, is waited for, s."""
GOOD_M, GOOD_RAD = 0.02, math.radians(0.5)
"""A pose whose own deviation is larger is no result."""


def main() -> int:
    """Look at every camera, fit, print, write; exit code 1, and nothing written, when a camera cannot be fitted."""
    defaults = CameraWatchParams()
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help="file to write, for real_cell.launch extrinsics:=FILE")
    parser.add_argument("--topics", nargs="+", default=list(defaults.camera_topics), help="clouds of the cameras")
    parser.add_argument("--clouds", type=int, default=30, help="clouds of each camera, averaged pixel by pixel")
    parser.add_argument("--points", type=int, default=8000, help="points near known solids, at most")
    parser.add_argument("--seed", type=int, default=1, help="of the points that are drawn")
    parser.add_argument("--rounds", type=int, default=2, help="fits to faces, each from where the one before has ended")
    arguments = parser.parse_args([word for word in sys.argv[1:] if not word.startswith("__")])
    init_command("calibrate_cameras")
    view = CellView()
    end = time.monotonic() + WAIT_S
    while not (view.heard and view.solids().static):
        if time.monotonic() > end or rospy.is_shutdown():
            return _fail(f"no static body with known solids in object_registry within {WAIT_S:g} s")
        time.sleep(0.1)
    poses: Dict[str, FloatArray] = {}
    said: List[str] = []
    for topic in arguments.topics:
        frame, refined, told = _fitted(view, topic, arguments)
        top = view.top_of(frame) if frame else None
        if top is None or not refined.ok:
            return _fail(f"{topic}: {refined.reason or f'no transform from world to {frame}'}")
        said.append(f"{topic}: {correction(refined, told)}")
        sys.stdout.write(f"{said[-1]}\n  {_quality(refined)}\n")
        sys.stdout.flush()
        if refined.sigma_m > GOOD_M or refined.sigma_rad > GOOD_RAD:
            return _fail(f"{topic}: the known bodies in view do not tell where it is: {_quality(refined)}")
        poses[top[0]] = refined.pose @ np.linalg.inv(top[1])
    write_poses(
        arguments.file, poses, "By calibrate_cameras, from known static bodies and the floor.\n" + "\n".join(said)
    )
    sys.stdout.write(f"{arguments.file}\n")
    return 0


def _fitted(view: CellView, topic: str, arguments: argparse.Namespace) -> Tuple[str, Refined, FloatArray]:
    """Frame of a camera, its pose, and the one that is told."""
    clouds, frame, told = [], "", np.eye(4)
    for _ in range(arguments.clouds):
        cloud = snapshot(topic, WAIT_S)
        pose = None if cloud.fault else view.pose_of(cloud.frame)
        if pose is None:
            reason = cloud.fault or f"no transform from {names.WORLD_FRAME} to {cloud.frame}"
            return cloud.frame, Refined(False, reason, told), told
        clouds.append(cloud.points)
        frame, told = cloud.frame, pose
    solids, rng = view.solids(), np.random.default_rng(arguments.seed)
    refined = calibrated(clouds, told, solids.static, solids.moving, rng, arguments.points, arguments.rounds)
    return frame, refined, told


def _quality(refined: Refined) -> str:
    sigma = f"{1000.0 * refined.sigma_m:.1f} mm and {math.degrees(refined.sigma_rad):.2f} deg of deviation"
    surfaces = f"{1000.0 * refined.before_m:.1f} mm to {1000.0 * refined.after_m:.1f} mm"
    return f"{refined.points} points; {sigma}; median distance to the surfaces from {surfaces}"


def _fail(reason: str) -> int:
    sys.stderr.write(f"calibrate_cameras: {reason}; nothing is written\n")
    return 1
