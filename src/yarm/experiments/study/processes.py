"""Processes that are there at once: copies of this one, with all that it has loaded and reckoned."""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
from concurrent.futures import Executor, ProcessPoolExecutor, wait
from typing import Iterator

from yarm.safety.supervise import die_with_parent


@contextlib.contextmanager
def copies(count: int) -> Iterator[Executor]:
    """So many copies of this process, which wait for work and end with the context, or with this process.

    A copy of a process with threads may wait for ever for what another thread held: make them before any is started,
    and before ROS is.
    """
    gc.freeze()  # what is shared stays shared: a copy's collector need not look at it
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("fork"), die_with_parent)
    try:
        wait([pool.submit(int) for _ in range(count)])  # with the first work the copies are made
        yield pool
    finally:
        pool.shutdown()
        gc.unfreeze()
