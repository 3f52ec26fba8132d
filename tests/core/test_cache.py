"""Compiled code is loaded from disk unless what it depends on has changed, whatever other processes write at the same time."""

import ast
import errno
import importlib.util
import os
import pwd
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings

import numba
import numpy as np
import pytest
from examples import GRANITE
from processes import PACKAGE, counted, finish, python, start

import demlaws as dl
from demlaws.core import cache, numba_compat
from demlaws.core.loops import FINITE, UNBOUNDED, batch_loop
from demlaws.plugins.engines import cache_folder

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
    stiffness, compiled, file = python(HERTZ, folder, PYTHONDONTWRITEBYTECODE=1, **changes).split(maxsplit=2)
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


def test_loading_is_not_called_a_compilation(tmp_path):
    """On a busy machine it takes more than a second, too: each start then announced a compilation that is done once."""
    code = """
        import contextlib
        from demlaws.core import numba_compat
        begun = []
        numba_compat.announced = lambda: contextlib.nullcontext(begun.append(1))
        import demlaws as dl
        dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).stiffness(1e-6)
        print(len(begun))
    """
    assert int(python(code, NUMBA_CACHE_DIR=tmp_path)) > 0
    assert python(code, NUMBA_CACHE_DIR=tmp_path) == "0"


def edited(file):
    """The file with a comment more and the time of before; returns its text of before."""
    text, before = file.read_text(), file.stat()
    file.write_text(f"{text}# edited\n")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    return text


@pytest.mark.slow  # what a user edits: test_machine_code_follows_an_edited_file
def test_machine_code_follows_the_content_of_the_package(tmp_path):
    """Neither the time of a file of core or laws matters, nor an edited file outside them. Machine code of files as they were
    before stays; in place of a corrupt file each process compiles its code again."""
    package, folder = copy(tmp_path / "one"), tmp_path / "cache"
    first, compiled = hertz(package, NUMBA_CACHE_DIR=folder)
    assert compiled > 3
    edited(package / "demlaws" / "plots" / "__init__.py")
    assert hertz(package, NUMBA_CACHE_DIR=folder) == (first, 0)
    for name in ("core/fastmath.py", "laws/hertz.py"):
        text = edited(package / "demlaws" / name)
        assert hertz(package, NUMBA_CACHE_DIR=folder)[1] > 3
        (package / "demlaws" / name).write_text(text)
    assert hertz(package, NUMBA_CACHE_DIR=folder) == (first, 0)
    for suffix in ("nbi", "nbc"):
        for file in folder.rglob(f"*.{suffix}"):
            file.write_bytes(file.read_bytes()[:-1000])
        again, compiled = hertz(package, NUMBA_CACHE_DIR=folder)
        assert again == first and compiled > 3
    assert hertz(package, NUMBA_CACHE_DIR=None)[1] > 3  # beside the files
    assert hertz(package, NUMBA_CACHE_DIR=None) == (first, 0)


def test_callbacks_are_told_apart_by_their_constants(tmp_path):
    code = """
        import ctypes, mine
        from numba import types
        from demlaws.core.numba_compat import callback
        for factor in (2.0, 3.0):
            made = callback(types.float64(types.float64), mine.scaled, {"FACTOR": factor})
            function = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(made.address)
            print(function(10.0), made.cache_hits, end=" ")
    """
    (tmp_path / "mine.py").write_text("FACTOR = None\n\ndef scaled(x):\n    return FACTOR * x\n")
    settings = {"PYTHONPATH": f"{tmp_path}:{PACKAGE.parent}", "NUMBA_CACHE_DIR": tmp_path / "cache"}
    assert python(code, **settings) == "20.0 0 30.0 0"
    assert python(code, **settings) == "20.0 1 30.0 1"


@pytest.mark.slow
def test_processes_that_compile_the_same_loops_at_once(tmp_path):
    """Two types of arguments for the same loops, from three processes that start together; then nothing is left to do, and
    each finds its own."""
    code = counted("""
        import demlaws as dl
        law = dl.law("NAME", dl.Contact(radius=1e-2, modulus=1e10, sigma=1e-6, fractal_dimension=2.2))
        print(repr(law.stiffness(1e-6)), repr(law.force(1e-6)), len(Count.compiled))
    """)
    names = ["hertz", "rms", "hertz"]
    together = [finish(p).split() for p in [start(code.replace("NAME", n), NUMBA_CACHE_DIR=tmp_path) for n in names]]
    assert all(sum(int(together[n][2]) for n in group) > 3 for group in ((0, 2), (1,)))  # the same loops are compiled once
    assert together[0][:2] == together[2][:2] and len({stiffness for stiffness, *_ in together}) == 2
    for name, (stiffness, force, _) in zip(names, together, strict=True):
        assert python(code.replace("NAME", name), NUMBA_CACHE_DIR=tmp_path).split() == [stiffness, force, "0"]
    left = [path.name for path in tmp_path.rglob("*") if path.is_file()]
    assert left and all(name.endswith((".nbi", ".nbc", ".py", ".digests", "lock")) for name in left), left


def test_each_set_of_types_has_a_name():
    """Two processes that write under one name at once may exchange their machine code: numba numbers its files."""
    law = dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10))
    batches = [(law, np.float64), (law, np.float32), (dl.law("rms", GRANITE, "elastic"), np.float64)]
    names = set()
    for law, kind in batches:
        overlap = np.full(4, 1e-6, kind)
        arguments = (law.rule_tag, law.shape, law.params, overlap, (), UNBOUNDED, FINITE, overlap, overlap)
        names.add(cache.name_of(batch_loop.py_func, tuple(map(numba.typeof, arguments)), {}))
    assert len(names) == len(batches) and None not in names


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_damaged_machine_code_is_compiled_again(tmp_path, suffix):
    """numba keeps no checksum: one changed byte gave 3e-321 N, or ended the process with SIGBUS."""
    first = hertz(NUMBA_CACHE_DIR=tmp_path)
    files = list(tmp_path.rglob(f"*.{suffix}"))
    for file in files:
        content = bytearray(file.read_bytes())
        content[len(content) // 2] ^= 0xFF
        file.write_bytes(content)
    assert files and hertz(NUMBA_CACHE_DIR=tmp_path) == first
    assert hertz(NUMBA_CACHE_DIR=tmp_path) == (first[0], 0)


@pytest.mark.parametrize("stop", [signal.SIGTERM, signal.SIGKILL])
def test_what_a_killed_process_left_is_removed(tmp_path, stop):
    """numba writes to a temporary file, which it then renames."""
    code = f"""
        import os
        os.replace = lambda *names: os.kill(os.getpid(), {int(stop)})
        import demlaws as dl
        dl.law("hertz", dl.Contact(radius=1e-2, modulus=1e10)).stiffness(1e-6)
    """
    process = start(code, NUMBA_CACHE_DIR=tmp_path)
    process.communicate(timeout=120)
    assert process.returncode == -stop
    assert any(".tmp." in file.name for file in tmp_path.rglob("*"))
    hertz(NUMBA_CACHE_DIR=tmp_path)
    assert not any(".tmp." in file.name for file in tmp_path.rglob("*"))


def test_loops_share_a_folder(tmp_path):
    """Each loop and set of types had folders of its own: 541 while the tests ran."""
    hertz(NUMBA_CACHE_DIR=tmp_path)
    folders = [path for path in tmp_path.rglob("*") if path.is_dir()]
    assert len(list(tmp_path.rglob("*.nbi"))) > 1 and len(folders) <= 2


def test_a_process_waits_for_another_that_compiles_the_same(tmp_path, theirs, monkeypatch):
    """Not for one that compiles anything else."""
    monkeypatch.setattr(cache, "_common_folder", lambda: tmp_path / "demlaws-0")
    (tmp_path / "demlaws-0").mkdir()
    code = """
        from pathlib import Path
        from demlaws.core import cache
        cache._common_folder = lambda: Path(FOLDER)
        with cache.placed(lambda x: x, NAME):
            print("in", flush=True)
    """
    codes = {name: code.replace("FOLDER", repr(str(tmp_path / "demlaws-0"))).replace("NAME", repr(name)) for name in "ab"}
    with cache.placed(theirs.double, "a"):
        assert python(codes["b"]) == "in"
        waiting = start(codes["a"])
        with pytest.raises(subprocess.TimeoutExpired):
            waiting.wait(timeout=3)
    assert finish(waiting) == "in"


def test_the_newest_machine_code_is_kept(tmp_path, theirs, monkeypatch):
    """A program that defines laws in a loop fills no disk."""
    folder = tmp_path / "demlaws-0"
    folder.mkdir()
    monkeypatch.setattr(cache, "_common_folder", lambda: folder)
    monkeypatch.setattr(cache, "_MOST", 2)
    for n in range(4):
        with cache.placed(theirs.double, f"double_{n}"):
            (folder / f"demlaws.double_{n}-1.nbi").write_bytes(b"code")
        os.utime(folder / f"double_{n}.digests", (n, n))
    assert [name for name in map("double_{}".format, range(4)) if cache.is_whole(name)] == ["double_2", "double_3"]
    assert not list(folder.glob("*double_0*"))


def test_no_folder_is_removed(tmp_path):
    """Neither of another program nor of another version, nor is one made before a loop is compiled."""
    others = [tmp_path / name for name in ("loops-a-py", "demlaws-0123456789abcdef", "numba")]
    for folder in others:
        folder.mkdir()
        (folder / "loops.follow_loop.nbc").write_bytes(b"")
        long_ago = time.time() - 400 * 86400
        os.utime(folder, (long_ago, long_ago))
    python("import demlaws.law, demlaws.core.loops, demlaws.driver", NUMBA_CACHE_DIR=tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted(others)
    hertz(NUMBA_CACHE_DIR=tmp_path)
    assert len(list(tmp_path.iterdir())) > len(others) and all(list(folder.iterdir()) for folder in others)


@pytest.fixture
def theirs(tmp_path, monkeypatch):
    """The module of a program that caches functions of its own."""
    file = tmp_path / "theirs.py"
    file.write_text("def double(x):\n    return 2.0 * x\n\n\ndef triple(x):\n    return 3.0 * x\n")
    spec = importlib.util.spec_from_file_location("theirs", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, "theirs", module)
    return module


def test_a_function_that_another_thread_caches_meanwhile_stays_in_its_folder(theirs, monkeypatch):
    """numba.config.CACHE_DIR was ours while a loop was compiled, for every thread."""
    found, njit = [], numba.njit

    def other_thread():
        found.append(njit(cache=True)(theirs.double).stats.cache_path)

    def watched(*arguments, **options):
        if options.get("cache"):
            thread = threading.Thread(target=other_thread)
            thread.start()
            thread.join()
        return njit(*arguments, **options)

    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    other_thread()
    monkeypatch.setattr(numba, "njit", watched)
    assert numba_compat.loop(theirs.triple)(2.0) == 6.0
    assert len(found) > 1 and len(set(found)) == 1


def test_a_full_disk_is_one_warning(theirs, monkeypatch):
    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(cache, "placed", full)
    with pytest.warns(UserWarning, match="cannot be kept.*No space left"):
        assert numba_compat.loop(theirs.triple)(2.0) == 6.0


def test_a_function_that_is_wrong_is_no_corrupt_file(theirs):
    """A bug that numba meets while it compiles is raised, without a word about the folder."""

    @numba.extending.intrinsic
    def broken(context, x):
        def write(context, builder, signature, arguments):
            raise KeyError("a bug")

        return numba.types.float64(numba.types.float64), write

    theirs.broken = broken
    exec("def use(x):\n    return broken(x)", vars(theirs))
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        with pytest.raises(Exception, match="a bug") as raised:
            numba_compat.loop(theirs.use)(2.0)
    assert not isinstance(raised.value, UserWarning)


def test_the_key_of_a_helper_does_not_depend_on_who_asks_first():
    """It was another one where a function had been visited before: an unchanged helper was compiled again and again."""

    @numba.njit
    def small(x):
        return x + 1.0

    @numba.njit
    def large(x):
        return 2.0 * small(x)

    again = []
    large.recompile = lambda: again.append(1)
    for things in ((small, large), (large, small), (large,), (small, large)):
        cache.content_key(things)
    assert again == []


def test_the_key_of_helpers_that_call_each_other():
    """That of each began with itself where it was asked first, and with the other where that was."""

    @numba.njit
    def even(n):
        return n == 0 or odd(n - 1)

    @numba.njit
    def odd(n):
        return n != 0 and even(n - 1)

    again = []
    even.recompile = odd.recompile = lambda: again.append(1)
    keys = [[cache.content_key(one) for one in order] for order in ((even, odd), (odd, even))]
    assert keys[0] == keys[1][::-1] and keys[0][0] != keys[0][1] and again == []


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
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(cache, "_is_writable", lambda folder: False)
    assert cache._common_folder.__wrapped__() is None
    with pytest.raises(dl.DemlawsError):
        cache_folder()


def test_kernels_that_other_folders_compile_are_in_every_digest():
    """The digest of a loop is that of its own folder and of `cache._SHARED`."""
    kernels, imports = {}, []
    for path in PACKAGE.rglob("*.py"):
        folder = path.relative_to(PACKAGE).parent.as_posix()
        tree = ast.parse(path.read_text())
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and any("kernel" in ast.unparse(one) for one in node.decorator_list):
                kernels[".".join(["demlaws", *path.relative_to(PACKAGE).with_suffix("").parts]), node.name] = folder
        imports += [
            (node.module, name.name, folder)
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom)
            for name in node.names
        ]
    homes = [(kernels[module, name], folder) for module, name, folder in imports if (module, name) in kernels]
    assert len(homes) > 50
    assert all(home in cache._SHARED or home == folder for home, folder in homes)


def test_code_of_one_text_in_two_files_is_kept_twice():
    """numba imports the module of the code that it loads, and the module of a file of laws is named by the file's place."""

    def force(p, x):
        return 2.0 * x

    first = cache.content_key(force)
    force.__module__ = "examples"
    assert cache.content_key(force) not in (first, None)
    force.__module__ = "demlaws_own_law_elsewhere"  # a module that is not imported by its name: not kept
    assert cache.content_key(force) is None
