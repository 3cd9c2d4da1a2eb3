#!/usr/bin/env python3
"""Every reader and every service of every Python node, told anything that can be sent, as often as you like.

    source tools/env.sh && python3 bench/readers.py --inputs 50000

The nodes are made without a ROS master (``test/support/ears.py``); each reader gets that many messages with absurd
numbers, wrong lengths and unknown names, one after the other, and the node's pass follows each. Prints how many each
node was told and each kind of exception once, with the first seed that raises it; exit code 1 when there was one.
``--nodes`` takes some of them alone. Services that wait for a thread cost a hundred times a message: they get a
hundredth.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Dict, List

import pytest
from random_messages import random_message

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from support.ears import NOW_S, Ears, arrived
from support.listeners import BUILDERS, NAMES

SERVICE_SHARE = 0.01
DEEP = 3
"""Innermost calls that tell one kind of exception from another."""


def told(name: str, inputs: int, first_seed: int, raised: Dict[str, str]) -> int:
    """Tell one node's readers; how much they were told. What raises is noted."""
    ears, count = Ears(), 0
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        ears.put_on(patch)
        work = BUILDERS[name](ears, Path(folder))
        for ear in list(ears.heard):
            wanted = max(1, round(inputs * SERVICE_SHARE)) if ear.is_service else inputs
            for seed in range(first_seed, first_seed + wanted):
                message = arrived(random_message(ear.sent_kind, random.Random(seed), NAMES, NOW_S))
                try:
                    ear.tell(message, work)
                except Exception as error:  # whatever it is, it would have ended a callback
                    calls = traceback.extract_tb(error.__traceback__)[-DEEP:]
                    where = " <- ".join(f"{Path(call.filename).name}:{call.lineno}" for call in reversed(calls))
                    raised.setdefault(f"{name} {ear.topic}: {where}", f"seed {seed}: {error!r}")
            count += wanted
    return count


def main() -> int:
    """Tell all of them, print the counts; 0 when nothing raised."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=1000, help="messages a reader")
    parser.add_argument("--seed", type=int, default=0, help="of the first message of each reader")
    parser.add_argument("--nodes", nargs="+", choices=list(BUILDERS), default=list(BUILDERS))
    options = parser.parse_args()
    counts: List[int] = []
    raised: Dict[str, str] = {}
    for name in options.nodes:
        began_s = time.process_time()
        counts.append(told(name, options.inputs, options.seed, raised))
        print(f"{name:24s} {counts[-1]:9d} inputs {time.process_time() - began_s:8.1f} s of processor time", flush=True)
    print("\n".join([*(f"{where}: {what}" for where, what in raised.items()), f"{sum(counts)} inputs"]))
    print(f"{len(raised)} kinds of exception")
    return 1 if raised else 0


if __name__ == "__main__":
    sys.exit(main())
