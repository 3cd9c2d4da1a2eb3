#!/usr/bin/env python3
"""How long perception takes from the last cloud of a set to the map, with recorded clouds at the cameras' 30 Hz.

    source tools/env.sh && python3 bench/perception_nodes.py

Records camera sets from the simulator once, then plays them (a C++ player and probe) to the nodes as they are shipped,
with and without another process keeping one core busy, for each back end, both ways of running the nodes, and with and
without visibility (what no camera sees). Prints a table, and one JSON object a line with ``--json``; what every single
set took goes to ``bench/data/perception_nodes.csv``, a row a case to ``perception_nodes_cases.csv``. ``--fuzz N`` also
tries N clouds with lies in their layout.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
from itertools import islice
from pathlib import Path
from typing import Any, Dict, Iterator, List, Tuple

import numpy as np
import psutil
import raw_rows

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "test"))
BUILD = Path(os.environ.get("YARM_BUILD", ROOT / "build"))
DEVEL = BUILD / "devel" if "YARM_BUILD" in os.environ else ROOT / "devel"
PORT = 11399
CASES = [
    ("fused", True, False, False),
    ("fused", True, True, False),
    ("fused", False, True, False),
    ("pcl", True, True, False),
    ("fused", True, False, True),
    ("fused", True, True, True),
]
"""Back end, in one process, one core busy, visibility."""
CASE = ("backend", "nodelets", "busy", "visibility")
CORES = ("perception", "merge_clouds", "cluster_assoc", "database")


@contextlib.contextmanager
def launched(command: List[str], log: Path) -> Iterator[subprocess.Popen]:
    """A child process that is stopped at the end."""
    with log.open("w") as output:
        child = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            yield child
        finally:
            child.send_signal(signal.SIGINT)
            try:
                child.wait(timeout=30.0)
            except subprocess.TimeoutExpired:
                child.kill()


@contextlib.contextmanager
def busy_core(wanted: bool) -> Iterator[None]:
    """Another process that never rests."""
    if not wanted:
        yield
        return
    child = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        child.kill()
        child.wait()


def record(path: Path, scene: str, sets: int) -> None:
    """Write camera sets of a simulated cell in motion, as they go over the wire."""
    from support import recorder  # noqa: PLC0415

    whole = list(islice(recorder.camera_sets(scene), sets + recorder.STILL_SETS))[-sets:]
    parts = [whole[-1].fixed_frames, whole[-1].registry]
    for taken in whole:
        parts += [taken.frames, *taken.messages()]
    with path.open("wb") as file:
        file.write(struct.pack("<II", sets, len(whole[0].clouds)))
        file.writelines(struct.pack("<I", len(part)) + part for part in parts)


def use_simulated_time() -> None:
    """Tell the nodes, once the master is up."""
    for _ in range(30):
        done = subprocess.run(["rosparam", "set", "/use_sim_time", "true"], check=False, stderr=subprocess.DEVNULL)
        if done.returncode == 0:
            return
        time.sleep(1.0)
    raise TimeoutError("no ROS master within 30 s")


def usage(processes: List[psutil.Process]) -> Dict[str, float]:
    """CPU seconds and minor page faults of some processes, in all."""
    total = {"cpu_s": 0.0, "faults": 0.0}
    for process in processes:
        times = process.cpu_times()
        total["cpu_s"] += times.user + times.system
        total["faults"] += float(Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()[7])
    return total


def perception_processes(launch: subprocess.Popen) -> List[psutil.Process]:
    """The C++ nodes that a roslaunch has started."""
    return [p for p in psutil.Process(launch.pid).children(recursive=True) if p.name() in CORES]


def measure(recording: Path, sets: int, case: Tuple[str, bool, bool, bool], folder: Path) -> Dict[str, Any]:
    """One case: what the player saw, and what the nodes used for it."""
    backend, nodelets, busy, visibility = case
    command = ["roslaunch", "yarm", "perception.launch", f"backend:={backend}"]
    command += [f"nodelets:={str(nodelets).lower()}", f"visibility:={str(visibility).lower()}"]
    with launched(command, folder / f"perception_{'_'.join(map(str, case))}.log") as launch:
        wanted = 1 if nodelets else 3
        end = time.monotonic() + 30.0
        while len(perception_processes(launch)) < wanted and time.monotonic() < end:
            time.sleep(0.1)
        time.sleep(3.0)
        processes = perception_processes(launch)
        before = usage(processes)
        with busy_core(busy):
            began = time.monotonic()
            player = subprocess.run(
                [str(DEVEL / "lib" / "yarm" / "perception_nodes_player"), str(recording), str(sets), "30"],
                capture_output=True,
                text=True,
                timeout=sets / 30.0 + 120.0,
                check=True,
            )
            elapsed = time.monotonic() - began
        after = usage(processes)
    result: Dict[str, Any] = json.loads(player.stdout)
    answered = [ms for ms in result["each_ms"] if ms is not None]
    p50, p99, most = np.percentile(answered, (50, 99, 100)) if answered else (math.nan,) * 3
    result.update(sent=len(result["each_ms"]), answered=len(answered), p50_ms=p50, p99_ms=p99, max_ms=most)
    result.update(zip(CASE, case), load=os.getloadavg()[0])
    result["cpu_ms_per_set"] = 1000.0 * (after["cpu_s"] - before["cpu_s"]) / sets
    result["faults_per_set"] = (after["faults"] - before["faults"]) / sets
    result["share_of_core"] = (after["cpu_s"] - before["cpu_s"]) / elapsed
    return result


def print_row(result: Dict[str, Any]) -> None:
    """One line of the table."""
    print(
        f"{result['backend']:6} {'nodelets' if result['nodelets'] else 'processes':9} "
        f"{'one core busy' if result['busy'] else 'quiet':13} {'visibility' if result['visibility'] else '':10} "
        f"{result['p50_ms']:7.1f} {result['p99_ms']:7.1f} "
        f"{result['max_ms']:7.1f} {result['sent'] - result['answered']:5d} of {result['sent']:5d} "
        f"{result['cpu_ms_per_set']:8.2f} {result['faults_per_set']:8.1f} {result['load']:6.1f}",
        flush=True,
    )


def save(results: List[Dict[str, Any]]) -> None:
    """The raw rows: a row a set, its latency empty when no map came, and a row a case."""
    sets = [
        {**{key: result[key] for key in CASE}, "set": number, "ms": "" if ms is None else ms}
        for result in results
        for number, ms in enumerate(result["each_ms"])
    ]
    raw_rows.save(raw_rows.DATA / "perception_nodes.csv", sets)
    whole = [{key: value for key, value in result.items() if key != "each_ms"} for result in results]
    ordered = [{key: row[key] for key in (*CASE, *(key for key in row if key not in CASE))} for row in whole]
    raw_rows.save(raw_rows.DATA / "perception_nodes_cases.csv", ordered)


def main() -> None:
    """Record, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default="2m1ma")
    parser.add_argument("--sets", type=int, default=930, help="sets played a case, the first 30 not measured")
    parser.add_argument("--record-sets", type=int, default=24)
    parser.add_argument("--recording", type=Path, help="use or make this recording")
    parser.add_argument("--cases", type=int, default=len(CASES), help="only the first cases")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--fuzz", type=int, default=0, help="clouds with lies to try under AddressSanitizer")
    options = parser.parse_args()
    targets = ["perception_nodes_player"] + (["cloud_reader_fuzz_test"] if options.fuzz else [])
    subprocess.run(["make", "-C", str(BUILD), *targets], check=True, stdout=subprocess.DEVNULL)
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{PORT}"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with launched(["roscore", "-p", str(PORT)], folder / "roscore.log"):
            use_simulated_time()
            recording = options.recording or folder / "sets.bin"
            if not recording.is_file():
                record(recording, options.scene, options.record_sets)
            print(f"{'':6} {'':9} {'':13} {'':10}  p50 ms  p99 ms  max ms  dropped        CPU ms/set faults/set  load")
            results = []
            for case in CASES[: options.cases]:
                results.append(measure(recording, options.sets, case, folder))
                print(json.dumps(results[-1])) if options.json else print_row(results[-1])
    save(results)
    if options.fuzz:
        subprocess.run([str(DEVEL / "lib" / "yarm" / "cloud_reader_fuzz_test"), str(options.fuzz)], check=True)


if __name__ == "__main__":
    main()
