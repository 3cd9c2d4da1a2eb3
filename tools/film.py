#!/usr/bin/env python3
"""Films a recorded mission as RViz shows it: docs/images/mission.gif. No display needed.

    source tools/env.sh
    rosrun yarm run_experiment --case 2m1ma --seed 8 --sync --speed 0 --bag
    python3 tools/film.py results/2m1ma_bin/8/run.bag docs/images/mission.gif --begin 42 --box 14 62 1280 800

The recording is played slowly (``--rate``), as RViz draws without a graphics card; frames are taken by simulated time.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import subprocess
import time
from pathlib import Path
from typing import Iterator, List, Tuple

import rospy
from PIL import Image, ImageGrab
from rosgraph_msgs.msg import Clock

from yarm.ros.experiment.launcher import Family, free_port

SCREEN = (1280, 800)
SILENCE_S = 60.0
"""Wall time without a clock after which the recording is over, or never began, s."""


@contextlib.contextmanager
def screen() -> Iterator[str]:
    """A display that nobody sees."""
    read, write = os.pipe()
    size = f"{SCREEN[0]}x{SCREEN[1]}x24"
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", size], pass_fds=[write], stderr=subprocess.DEVNULL
    )
    try:
        os.close(write)
        with os.fdopen(read) as number:
            yield ":" + number.readline().strip()
    finally:
        server.terminate()
        server.wait()


@contextlib.contextmanager
def replay(bag: Path, rate: float, display: str) -> Iterator[subprocess.Popen[bytes]]:
    """The recording in RViz on a display, with a ROS master of its own, which this process uses too."""
    os.environ.update(ROS_MASTER_URI=f"http://localhost:{free_port()}", DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1")
    port = os.environ["ROS_MASTER_URI"].rsplit(":", 1)[1]
    words = [f"bag:={bag.resolve()}", f"rate:={rate:g}"]
    child = subprocess.Popen(
        ["roslaunch", "-p", port, "yarm", "replay.launch", *words], stdout=subprocess.DEVNULL, start_new_session=True
    )
    try:
        yield child
    finally:
        Family(child).stop()


def frames(
    display: str, child: subprocess.Popen[bytes], begin_s: float, end_s: float, every_s: float
) -> List[Image.Image]:
    """Pictures of the screen, one each ``every_s`` simulated seconds, from ``begin_s`` to ``end_s`` or the end."""
    times: List[Tuple[float, float]] = []
    rospy.Subscriber("/clock", Clock, lambda message: times.append((time.monotonic(), message.clock.to_sec())))
    taken: List[Image.Image] = []
    next_s, since = begin_s, time.monotonic()
    while child.poll() is None and (not times or times[-1][1] < end_s):
        heard, now_s = times[-1] if times else (since, 0.0)
        if time.monotonic() - heard > SILENCE_S:
            break
        if times and now_s >= next_s:
            taken.append(ImageGrab.grab(xdisplay=display))
            next_s += every_s
        time.sleep(0.05)
    return taken


def main() -> None:
    """Play, take pictures, write them as one GIF."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", type=Path, help="of run_experiment --bag")
    parser.add_argument("gif", type=Path)
    parser.add_argument("--begin", type=float, default=0.0, help="simulated time of the first picture, s")
    parser.add_argument("--end", type=float, default=float("inf"), help="simulated time at which to stop, s")
    parser.add_argument("--every", type=float, default=0.8, help="simulated seconds from picture to picture")
    parser.add_argument("--show", type=float, default=0.25, help="seconds that each picture is shown")
    parser.add_argument("--rate", type=float, default=0.2, help="speed of the replay")
    parser.add_argument("--box", type=int, nargs=4, default=(0, 0, *SCREEN), help="left upper right lower, pixels")
    parser.add_argument("--width", type=int, default=720, help="pixels of the GIF")
    options = parser.parse_args()
    with screen() as display, replay(options.bag, options.rate, display) as child:
        rospy.init_node("film", disable_signals=True)
        taken = frames(display, child, options.begin, options.end, options.every)
    if not taken:
        raise SystemExit(f"{options.bag}: nothing was shown; is it a recording of run_experiment --bag?")
    box = options.box
    height = round(options.width * (box[3] - box[1]) / (box[2] - box[0]))
    small = [picture.crop(box).resize((options.width, height), Image.LANCZOS) for picture in taken]
    shown = [picture.quantize(64, dither=Image.Dither.NONE) for picture in small]
    shown[0].save(
        options.gif, save_all=True, append_images=shown[1:], duration=round(1000 * options.show), loop=0, optimize=True
    )
    print(f"{options.gif}: {len(shown)} pictures, {options.gif.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
