"""A process that is made by fork while another thread compiles."""

import os
import subprocess
import sys

SCRIPT = """
import os, signal, threading
import demlaws as dl
from demlaws.core import numba_compat
started, real = threading.Event(), numba_compat.announced
def announced():
    started.set()
    return real()
numba_compat.announced = announced
numba_compat.cache.name_of = lambda *arguments: None  # nothing is kept: the thread compiles
pair = dl.Contact(4e-3, 32e9)
thread = threading.Thread(target=lambda: dl.law("hertz", pair).force(1e-6))
thread.start()
started.wait()
child = os.fork()
if child == 0:
    signal.alarm(100)
    os._exit(0 if abs(dl.law("hertz", pair).force(1e-6) / 2.6985 - 1.0) < 1e-4 else 1)
print(os.waitpid(child, 0)[1])
thread.join()
"""


def test_the_child_compiles_too():
    """It does not wait for a lock that a thread of its parent holds."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=dict(os.environ))
    assert done.stdout == "0\n", done
