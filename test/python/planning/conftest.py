"""Property tests of this folder: no time limits (the machine may be busy), the same examples every time."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("planning", deadline=None, derandomize=True)
settings.load_profile("planning")
