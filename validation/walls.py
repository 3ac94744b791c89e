"""Walls with studs against a periodic wall solved as a whole: ``docs/validation/walls.md``.

Run it as ``python -m validation.walls > docs/validation/walls.md``; a minute of computing.
"""

from __future__ import annotations
