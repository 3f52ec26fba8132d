"""Compiled code comes from the disk, never from yesterday, whatever other processes write at the same time."""

import os
import pwd
import runpy
import shutil
import sys
import time

import pytest
from processes import PACKAGE, counted, finish, python, start

import demlaws as dl
from demlaws.core import cache
from demlaws.engines import cache_folder

EVERY_LAW = counted(f"""
    import pytest
    every = ["{PACKAGE.parent}/tests/test_driver.py", "-k", "displacement or nothing or impact or timestep", "-m", ""]
    assert pytest.main(["-q", "-n0", "-p", "no:cacheprovider", *every]) == 0
    print(len(Count.compiled), *Count.compiled[:5])
""")
HERTZ = counted("""
    import demlaws as dl
    law = dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10))
    print(repr(law.stiffness(1e-6)), len(Count.compiled), dl.__file__)
""")


def hertz(folder=PACKAGE.parent, **changes):
    """Stiffness of Hertz's law and the number of functions compiled for it, from the package in `folder`."""
    # Python's own cache depends on the time of a file
    stiffness, compiled, file = python(HERTZ, folder, PYTHONDONTWRITEBYTECODE=1, **changes).split()
    assert file.startswith(str(folder))
    return float(stiffness), int(compiled)


def copy(folder):
    """A checkout of its own."""
    shutil.copytree(PACKAGE, folder / "demlaws", ignore=shutil.ignore_patterns("__pycache__"), copy_function=shutil.copyfile)
    return folder


@pytest.mark.slow
def test_a_second_process_compiles_nothing():
    """The loops of the drivers, with every law and every rule."""
    python(EVERY_LAW)
    compiled, *which = python(EVERY_LAW).splitlines()[-1].split()
    assert compiled == "0", which


def edited(file):
    """The file with a comment more and the time of before; returns its text of before."""
    text, before = file.read_text(), file.stat()
    file.write_text(f"{text}# edited\n")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    return text


@pytest.mark.slow  # what a user edits: test_machine_code_follows_an_edited_file
def test_machine_code_follows_the_content_of_the_package(tmp_path):
    """Neither the place nor the time of the files matters, nor an edited file outside core and laws: equal checkouts share a
    cache. The machine code of files as they were before stays; a corrupt file is compiled again."""
    one, other, cache = copy(tmp_path / "one"), copy(tmp_path / "other"), tmp_path / "cache"
    first, compiled = hertz(one, NUMBA_CACHE_DIR=cache)
    assert compiled > 3
    edited(other / "demlaws" / "plots" / "__init__.py")
    assert hertz(other, NUMBA_CACHE_DIR=cache) == (first, 0)
    for name in ("core/fastmath.py", "laws/hertz.py"):
        text = edited(other / "demlaws" / name)
        assert hertz(other, NUMBA_CACHE_DIR=cache)[1] > 3
        (other / "demlaws" / name).write_text(text)
    assert hertz(other, NUMBA_CACHE_DIR=cache) == (first, 0)
    for file in cache.rglob("*.nbc"):
        file.write_bytes(file.read_bytes()[:-1000])
    again, compiled = hertz(one, NUMBA_CACHE_DIR=cache)
    assert again == first and compiled > 3
    assert hertz(one, NUMBA_CACHE_DIR=cache) == (first, 0)
    assert hertz(one, NUMBA_CACHE_DIR=None)[1] > 3 and hertz(one, NUMBA_CACHE_DIR=None) == (first, 0)  # beside the files


@pytest.mark.parametrize("plain", ["", pytest.param("1", marks=pytest.mark.slow)])
def test_callbacks_are_told_apart_by_their_constants(tmp_path, plain):
    code = """
        import ctypes, mine
        from numba import types
        from demlaws.core.numba_compat import callback
        for factor in (2.0, 3.0):
            made = callback(types.float64(types.float64), mine.scaled, {"FACTOR": factor})
            function = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(made.address)
            print(function(10.0), getattr(made, "cache_hits", 0), end=" ")
    """
    (tmp_path / "mine.py").write_text("FACTOR = None\n\ndef scaled(x):\n    return FACTOR * x\n")
    settings = {
        "PYTHONPATH": f"{tmp_path}:{PACKAGE.parent}",
        "NUMBA_CACHE_DIR": tmp_path / "cache",
        "DEMLAWS_PLAIN_NUMBA": plain,
    }
    assert python(code, **settings).split()[::2] == ["20.0", "30.0"]
    assert plain or python(code, **settings) == "20.0 1 30.0 1"


@pytest.mark.slow
def test_processes_that_compile_the_same_loops_at_once(tmp_path):
    """Two types of arguments for the same loops, from three processes that start together; then nothing is left to do, and
    each finds its own."""
    code = counted("""
        import demlaws as dl
        law = dl.law("NAME", dl.Contact(radius=1e-2, modulus=1e10, roughness=1e-6, fractal_dimension=2.2))
        print(repr(law.stiffness(1e-6)), repr(law.force(1e-6)), len(Count.compiled))
    """)
    names = ["hertz", "rms", "hertz"]
    together = [finish(p).split() for p in [start(code.replace("NAME", n), NUMBA_CACHE_DIR=tmp_path) for n in names]]
    assert all(int(compiled) > 3 for *_, compiled in together)
    assert together[0][:2] == together[2][:2] and len({stiffness for stiffness, *_ in together}) == 2
    for name, (stiffness, force, _) in zip(names, together, strict=True):
        assert python(code.replace("NAME", name), NUMBA_CACHE_DIR=tmp_path).split() == [stiffness, force, "0"]
    left = [path.name for path in tmp_path.rglob("*") if path.is_file()]
    assert left and all(name.endswith(".nbc") for name in left), left


def test_what_another_process_uses_is_kept(tmp_path):
    """The machine code of another version goes when it has not been used for a day, not before."""
    fresh, abandoned, stranger = (tmp_path / name for name in ("loops-a-py", "loops-b-py", "numba"))
    for folder in (fresh, abandoned, stranger):
        folder.mkdir()
        (folder / "loops.follow_loop.nbc").write_bytes(b"")
        yesterday = time.time() - (25 if folder is not fresh else 23) * 3600
        os.utime(folder, (yesterday, yesterday))
    hertz(NUMBA_CACHE_DIR=tmp_path)
    assert fresh.is_dir() and stranger.is_dir() and not abandoned.exists()


def test_works_where_no_folder_takes_a_cache():
    """A package installed where its user may not write, who has no home to write to either: slower, not broken."""
    stiffness, compiled = hertz(NUMBA_CACHE_DIR="/dev/null/nowhere")
    assert stiffness > 0 and compiled > 3


def test_a_user_without_a_home(monkeypatch):
    """In a container: neither HOME nor an entry. It ended in a RuntimeError of pathlib when a law was made."""

    def no_entry(uid):
        raise KeyError(f"getpwuid(): uid not found: {uid}")

    for name in ("HOME", "XDG_CACHE_HOME", "DEMLAWS_CACHE"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", no_entry)
    assert runpy.run_path(cache.__file__)["FOLDER"] == cache.FOLDER
    with pytest.raises(dl.DemlawsError):
        cache_folder()


@pytest.mark.skipif(sys.platform != "linux", reason="forks")
def test_a_second_process_begins_with_the_last_jobs(monkeypatch):
    """It ends with the jobs, and does none that this process has come to; where it dies, this process does them."""
    monkeypatch.setattr(cache, "_can_fork", lambda: True)
    here = os.getpid()

    def work(job):
        if job == "dies" and os.getpid() != here:
            os._exit(1)
        time.sleep(0.3)
        return job, os.getpid()

    found = list(cache.shared(["a", "b", "c", "d", "e", "f"], work))
    assert [job for job, _ in found] == ["a", "b", "c", "d", "e", "f"]
    assert found[0][1] == here != found[-1][1] and len({process for _, process in found}) == 2
    with pytest.raises(ProcessLookupError):
        os.kill(found[-1][1], 0)
    assert [job for job, _ in cache.shared(["a", "b", "dies", "d"], work)] == ["a", "b", "dies", "d"]
    assert {process for _, process in cache.shared(["a", "b"], work)} == {here}
