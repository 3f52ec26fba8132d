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


IMPORTS = """
import multiprocessing, threading

def work():
    import demlaws as dl
    return dl.law("hertz", dl.Contact(4e-3, 32e9)).force(1e-6)

if __name__ == "__main__":
    thread = threading.Thread(target=work)
    thread.start()
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(thread.is_alive(), round(pool.apply_async(work).get(100), 3))
    thread.join()
"""


def test_a_spawned_process_works_while_a_thread_imports(tmp_path):
    """A forked one waits for an import lock of CPython that nobody holds, with any package (docs/how-to/cluster.md)."""
    (tmp_path / "script.py").write_text(IMPORTS)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=200)
    assert done.stdout.endswith(" 2.698\n"), done


def test_the_child_compiles_too():
    """It does not wait for a lock that a thread of its parent holds."""
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, env=dict(os.environ))
    assert done.stdout == "0\n", done
