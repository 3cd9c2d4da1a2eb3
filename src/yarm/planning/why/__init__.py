"""Why a goal is not reached, and the smallest change that would make it reachable."""
