"""``python3 -m yarm.planning``: see ``yarm.planning.cli``."""

from __future__ import annotations

import sys

from yarm.planning.cli import main

sys.exit(main())
