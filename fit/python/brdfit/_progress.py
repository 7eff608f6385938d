"""Progress of calls over a second: a bar of tqdm where it is installed, or whatever the caller gives."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Union

#: True: a bar. False: none. None: a bar on a terminal and in a notebook, where tqdm is installed.
#: A function: called with the share done, from 0 to 1, and what is being done, about 20 times a second.
Progress = Union[bool, Callable[[float, str], object], None]


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and "IPKernelApp" in shell.config


@contextmanager
def reporter(progress: Progress, what: str) -> Iterator[Callable[[float, str], object] | None]:
    """What _brdfit calls with share and text, or None."""
    if callable(progress):
        yield progress
        return
    if progress is False or (progress is None and not (sys.stderr.isatty() or _in_notebook())):
        yield None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if progress is None:
            yield None
            return
        raise ModuleNotFoundError("progress=True needs tqdm: pip install tqdm") from None
    bar: Any
    with tqdm(total=1.0, desc=what, delay=1, leave=False, bar_format="{desc}: {percentage:3.0f}%|{bar}| {remaining}") as bar:

        def show(share: float, now: str) -> None:
            if now:
                bar.set_description_str(now, refresh=False)
            bar.update(share - bar.n)

        yield show
