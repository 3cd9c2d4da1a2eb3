"""``python3 -m yarm.planning``: see ``yarm.planning.tools.cli``."""

from __future__ import annotations

import sys

from yarm.planning.tools.cli import main

sys.exit(main())
