"""build, run, check, export and their command line."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from inputs import GRANITE, HOME, ROUGH, part

import demlaws as dl
import demlaws.liggghts as lg
from demlaws.errors import DemlawsError
from demlaws.liggghts.check import TWO_PARTICLES, versions
from demlaws.liggghts.run import executable

build_module = part("liggghts", "build")


def printed(*words):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=True).stdout


# --- build


def test_only_our_own_symbols_stay_hidden():
    """A preloaded object that exported LIGGGHTS's templates would replace those of the binary."""
    assert printed("nm", "-D", "--defined-only", lg.build()).strip() == ""


LDD_SID = """\
\tlinux-vdso.so.1 (0x00007f7b6aa01000)
\tlibmpi.so.40 => /usr/lib/x86_64-linux-gnu/libmpi.so.40 (0x00007f7b6a91e000)
\tlibvtkParallelMPI-9.6.so.1 => /usr/lib/x86_64-linux-gnu/libvtkParallelMPI-9.6.so.1 (0x00007f7b6a8d2000)
\tlibgone_mpi.so.1 => not found
\tlibopen_mpi.so.40 => /usr/lib/x86_64-linux-gnu/libopen_mpi.so.40 (0x00007f7b62e00000)
"""


def test_mpi_is_what_libliggghts_loads(monkeypatch):
    """Debian sid's Open MPI 6 keeps ompi_mpi_double in libopen_mpi, which only libmpi asks for."""
    monkeypatch.setattr(build_module, "output_of", lambda command: LDD_SID)
    names = [Path(path).name for path in build_module.mpi_libraries("/usr/lib/libliggghts.so")]
    assert names == ["libmpi.so.40", "libvtkParallelMPI-9.6.so.1", "libopen_mpi.so.40"]
    monkeypatch.setattr(build_module, "output_of", lambda command: "libc.so.6 => /lib/libc.so.6")
    with pytest.raises(DemlawsError, match="no MPI"):
        build_module.mpi_libraries("/usr/lib/libliggghts.so")


def test_library_and_headers_are_those_of_the_binary(tmp_path, monkeypatch):
    """A user-built LIGGGHTS beside Debian's: nothing of the one goes into a plugin for the other."""
    binary, own, system = tmp_path / "liggghts", tmp_path / "lib" / "libliggghts.so", "/usr/lib/libliggghts.so"
    binary.touch(0o755)
    monkeypatch.setenv("DEMLAWS_LIGGGHTS", str(binary))
    monkeypatch.delenv("DEMLAWS_LIGGGHTS_INCLUDE", raising=False)
    monkeypatch.delenv("CXX", raising=False)
    answers = {"ldd": f"\tlibliggghts.so => {own} (0x00007f7b)\n", "g++": f"{system}\n"}
    monkeypatch.setattr(build_module, "output_of", lambda command: answers[command[0]])
    assert build_module.engine_library() == own
    with pytest.raises(DemlawsError, match=f"not in {tmp_path}/include: .*DEMLAWS_LIGGGHTS_INCLUDE"):
        build_module.headers()
    (tmp_path / "include" / "liggghts").mkdir(parents=True)
    (tmp_path / "include" / "liggghts" / "contact_models.h").touch()
    assert build_module.headers() == tmp_path / "include" / "liggghts"
    monkeypatch.setenv("DEMLAWS_LIGGGHTS_INCLUDE", str(tmp_path / "lib"))
    with pytest.raises(DemlawsError, match=f"not in {tmp_path}/lib"):
        build_module.headers()
    answers["ldd"] = f"\t{own} (0x00007f7b)\n"  # linked by its path
    assert build_module.engine_library() == own
    answers["ldd"] = ""  # a script that starts it
    assert build_module.engine_library() == Path(system)
    answers["g++"] = "libliggghts.so\n"
    with pytest.raises(DemlawsError, match="leads to a lib"):
        build_module.engine_library()
    answers["ldd"] = "\tlibliggghts.so => not found\n\tlibc.so.6 => /lib/libc.so.6 (0x00007f7b)\n"
    with pytest.raises(DemlawsError, match="LD_LIBRARY_PATH"):
        lg.build()
    answers["ldd"] = "\tlibmpi.so.40 => /lib/libmpi.so.40 (0x00007f7b)\n"  # what LIGGGHTS's own CMakeLists makes
    with pytest.raises(DemlawsError, match="contains LIGGGHTS statically"):
        lg.build()


def test_plugin_loads_the_mpi_of_liggghts_and_no_other():
    def loaded(path):
        names = [line.split()[0] for line in printed("ldd", path).splitlines()]
        return {name for name in names if "mpi" in name.lower()}

    assert loaded(lg.build()) == loaded(executable()) != set()


@pytest.mark.slow
def test_our_sources_compile_without_a_warning():
    """-Wall -Wextra as errors; LIGGGHTS's own headers are system headers. Stock code inlined into ours is not ours."""
    words = [word for word in build_module.PLUGIN.compile_command(portable=True) if word not in ("-w", "-shared", "-O3")]
    strict = ["-Wall", "-Wextra", "-Werror", "-Wno-maybe-uninitialized", "-fsyntax-only"]
    done = subprocess.run(words + strict, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[:2000]


# --- check


def test_other_versions_and_builds_are_refused(tmp_path, monkeypatch):
    head = "cat <<E\nLIGGGHTS (Version LIGGGHTS-PUBLIC {}, compiled)\n* Atom styles:\ngranular {}\n* Integrate styles:\nE\n"
    broken = "echo error while loading shared libraries: libliggghts.so >&2; exit 127\n"
    for number, (text, message) in enumerate(
        (
            (head.format("3.8.0", "sphere"), None),
            (head.format("4.0.0", "sphere"), r"3\.8\.0"),
            (head.format("3.8.0", "superquadric"), "superquadric"),
            (broken, r"cannot be started: .*libliggghts\.so"),
        )
    ):
        fake = tmp_path / f"liggghts{number}"
        fake.write_text(f"#!/bin/sh\n{text}")
        fake.chmod(0o755)
        monkeypatch.setenv("DEMLAWS_LIGGGHTS", str(fake))
        if message is None:
            assert versions() == "LIGGGHTS-PUBLIC 3.8.0"
        else:
            with pytest.raises(DemlawsError, match=message):
                versions()


# --- export


def test_the_case_runs_in_the_liggghts_that_is_named(tmp_path):
    """With a stock model; the shared tests run it with ours."""
    path = lg.export(tmp_path, grains=[lg.Grain(0.004, GRANITE, ROUGH)], count=10, rtol=1e-3, stock="hertz")
    path.write_text(re.sub(r"steps index \d+", "steps index 20", path.read_text()))
    (tmp_path / "own liggghts").symlink_to(executable())
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "liggghts").write_text("#!/bin/sh\nexit 7\n")
    (tmp_path / "bin" / "liggghts").chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": HOME, "DEMLAWS_LIGGGHTS": str(tmp_path / "own liggghts")}
    environment["PATH"] = f"{tmp_path / 'bin'}:{os.environ['PATH']}"
    result = subprocess.run([str(tmp_path / "run.sh")], env=environment, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout[-2000:] + result.stderr
    assert lg.read_log(tmp_path / "log.liggghts")["Step"][-1] == 21


@pytest.mark.slow
@pytest.mark.parametrize("stock", [None, "hertz"])
def test_the_exported_case_settles(tmp_path, stock):
    """It ends by itself with all grains in and at rest, before its longest time, and they lie where they can."""
    grains = [lg.Grain(radius, GRANITE, ROUGH) for radius in (0.004, 0.005)]
    path = lg.export(tmp_path, grains=grains, count=40, stock=stock)
    longest = int(re.search(r"steps index (\d+)", path.read_text())[1])
    log = lg.run(path, plugin=stock is None)
    mass = np.mean([grain.mass for grain in grains])
    assert log["Atoms"][-1] == 40 and log["Step"][-1] < longest
    assert log["KinEng"][-1] <= 1e-5 * 40 * mass * 9.81 * 0.005 < 1e-3 * log["KinEng"].max()
    last = max((tmp_path / "post").glob("grains.*"), key=lambda file: int(file.name.split(".")[1]))
    rows = np.loadtxt(last, skiprows=9)
    assert np.abs(rows[:, 4] - rows[:, 5]).min() < 1e-6  # some on the floor, to micrometres
    assert np.linalg.norm(rows[:, 6:9], axis=1).max() < 0.01


def test_stock_fit_in_the_stock_binary(tmp_path):
    """The fitted stock model, run without the plugin, meets the law at the stated load and errs elsewhere as printed."""
    grain = lg.Grain(0.0087, GRANITE, ROUGH)
    law = dl.law("pohrt-popov", grain.contact(grain), unloading="hertz")
    loads = np.array([0.5, 3.0, 10.0, 40.0])
    fit = lg.stock_fit(law, 10.0, forces=loads)
    assert fit.error[2] == pytest.approx(0.0, abs=1e-12)
    case = lg.export(tmp_path, "pohrt-popov", [grain], stock="hertz", max_force=10.0).read_text()
    # no damping, so that the force is the model's own at any speed
    case = re.sub(r"(Restitution .*) 0.5 0.5 0.5 0.5", r"\1 1 1 1 1", case)
    model = re.findall("^(?:fix             p|pair_style).*$", case, re.MULTILINE)
    assert model[-1].split()[3] == "hertz"
    text = TWO_PARTICLES.split("velocity        right set 0.2")[0].replace("create_box      1 box", "create_box      2 box")
    text = re.sub(r"^fix             m[1-4].*\n", "", text, flags=re.MULTILINE)
    text = re.sub("^pair_style.*$", "\n".join(model), text, flags=re.MULTILINE).replace("thermo          20", "thermo 2")
    (tmp_path / "in.stock").write_text(text)
    log = lg.run(tmp_path / "in.stock", variables={"young": 0, "radius": 0.0087, "table": "none"}, plugin=False)
    overlaps = law.overlap(loads)
    force = np.interp(overlaps, log["overlap"], log["force"])
    inside = overlaps < log["overlap"].max()
    assert inside[:3].all()
    assert np.abs(force / loads - 1 - fit.error)[inside].max() <= 1e-3  # thermo rows are 4 nm apart
