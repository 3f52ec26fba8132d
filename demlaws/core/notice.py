"""A line for a compilation that takes longer than a second: once in a process, to the standard error."""

import sys
import threading

told = False
timers: list[threading.Timer] = []


def _tell() -> None:
    global told
    if not told:
        told = True
        text = (
            "demlaws: compiling these laws for this machine, some 2 to 10 s where nothing else runs; this is done once and kept"
        )
        print(text, file=sys.stderr, flush=True)


def begin() -> None:
    """Machine code of a loop was not found: its compilation begins."""
    if not told:
        timer = threading.Timer(1.0, _tell)
        timer.daemon = True
        timer.start()
        timers.append(timer)


def end() -> None:
    """The compilation that began last has ended."""
    if timers:
        timers.pop().cancel()
