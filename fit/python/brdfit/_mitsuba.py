"""Files that Mitsuba reads, for as long as this process lives."""

from __future__ import annotations

import os
import tempfile

_folder: tempfile.TemporaryDirectory[str] | None = None
_count = 0


def temporary_file() -> str:
    """The name of a new .bsdf file, which goes when Python ends."""
    global _folder, _count
    if _folder is None:
        _folder = tempfile.TemporaryDirectory(prefix="brdfit-")
    _count += 1
    return os.path.join(_folder.name, f"{_count}.bsdf")
