"""Callback for a compilation that takes longer than a second; the command line sets `say`."""

import threading

say = None
"""Called without arguments, once in a process; None: no notice."""
timers = []


def _tell():
    global say
    callback, say = say, None
    if callback is not None:
        callback()


def begin():
    """Machine code of a loop was not found: its compilation begins."""
    if say is not None:
        timer = threading.Timer(1.0, _tell)
        timer.daemon = True
        timer.start()
        timers.append(timer)


def end():
    """The compilation that began last has ended."""
    if timers:
        timers.pop().cancel()
