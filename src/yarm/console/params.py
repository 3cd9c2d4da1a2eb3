"""Parameters of the console."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class ConsoleParams:
    """Everything about the console that can be set."""

    host: str = param("127.0.0.1", "", "address to listen on; on any other than loopback everything needs the token")
    port: int = param(8470, "", "port to listen on; 0 takes a free one", 0, 65535)
    token_file: str = param("", "", "file with the token, readable by its owner alone; empty: a new one at each start")
    rate_hz: float = param(10.0, "Hz", "pictures a second of wall time that an open page gets", 1.0, 30.0)
    answer_s: float = param(5.0, "s", "wall time that the cell has to answer a command", 0.5, 60.0)
    film_s: float = param(
        600.0,
        "s",
        "simulated time that a page can look back; 0 keeps nothing, and then nothing is drawn unseen",
        0.0,
        7200.0,
    )
    film_hz: float = param(5.0, "Hz", "pictures a second of wall time that are kept for that", 0.5, 10.0)
    results: str = param("results", "", "folder of results that a page lists; it may come to be later")
    health_s: float = param(5.0, "s", "wall time between two looks at the nodes' processes", 1.0, 60.0)
