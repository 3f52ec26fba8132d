"""Callback for a compilation that takes longer than a second; the command line gives one while a command runs (`by`)."""

import contextlib
import threading

say = None
"""Called without arguments, at the first such compilation; None: no notice."""
timers = []


@contextlib.contextmanager
def by(callback):
    """Within this context `say` is the callback; then what it was before."""
    global say
    before, say = say, callback
    try:
        yield
    finally:
        say = before


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
