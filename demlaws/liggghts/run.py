"""LIGGGHTS as a program: the stock binary with the plugin preloaded, on one rank or many."""

import functools
import os
import re
import shutil
import subprocess
from pathlib import Path

from demlaws.errors import DemlawsError
from demlaws.liggghts.build import PACKAGES, build
from demlaws.plugins.engines import Engine, output_of, own_session

VERSION = "3.8.0"
HEAD = """\
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
units           si
hard_particles  yes
"""
"""How our own inputs begin: spheres, SI units, moduli of stone."""

SERIAL_ONLY = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
"""Of a process that is its only rank: without a daemon and a look for networks, which Open MPI starts with, half a second."""


def executable():
    """Path of the liggghts binary (DEMLAWS_LIGGGHTS or the first on PATH); else DemlawsError."""
    name = os.environ.get("DEMLAWS_LIGGGHTS", "liggghts")
    path = shutil.which(name)
    if not path:
        raise DemlawsError(f"{name!r} not found: {PACKAGES}, or set DEMLAWS_LIGGGHTS to the binary")
    return os.path.abspath(path)  # it is started in the input's folder


@functools.lru_cache
def _version_of(binary):
    with own_session(os.environ) as environment:
        result = subprocess.run([binary, "-h"], capture_output=True, text=True, env=environment)
    text = result.stdout
    if result.returncode and not text:  # a library that it does not find
        raise DemlawsError(f"{binary} cannot be started: {result.stderr.strip()[:300]}")
    match = re.search(r"Version (LIGGGHTS\S*) (\S+?),", text)
    if not match or match.group(2) != VERSION:
        raise DemlawsError(f"the plugin is for LIGGGHTS {VERSION}, the binary is {match.group(0) if match else text[:80]!r}")
    styles = text.split("Atom styles", 1)[-1].split("* Integrate", 1)[0]
    if "superquadric" in styles or "convexhull" in styles:
        raise DemlawsError("this LIGGGHTS is a superquadric or convex build: its data differ; use Debian's package liggghts")
    return f"{match.group(1)} {match.group(2)}"


def built_in():
    """Whether the binary, or the libliggghts that it loads, was built with the models in it (`demlaws liggghts source`)."""
    files = [executable(), *re.findall(r"(/\S*/libliggghts[^/\s]*) \(0x", output_of(["ldd", executable()]))]
    return any(b"model demlaws/table" in Path(file).read_bytes() for file in files)


def versions():
    """Version of the binary; DemlawsError unless the plugin is for it, or a superquadric build."""
    return _version_of(executable())


class _Liggghts(Engine):
    name, begins, log = "LIGGGHTS", "Memory usage", "log.liggghts"

    def start(self, ranks, plugin, portable):
        environment, loading = dict(os.environ), {}
        if plugin and not built_in():
            versions()  # loaded into another LIGGGHTS, the plugin would crash it or worse
            loading = {"LD_PRELOAD": ":".join(p for p in (str(build(portable)), environment.get("LD_PRELOAD")) if p)}
        if ranks == 1 and not any(name.startswith(("OMPI_COMM_", "PMIX_", "PMI_")) for name in environment):  # no mpirun
            environment = SERIAL_ONLY | environment
        # without the plugin LIGGGHTS's error would be lost: it is buffered where the output goes to a pipe
        buffered = not plugin and shutil.which("stdbuf")
        return [*(["stdbuf", "-oL"] if buffered else []), executable()], environment, loading, None


ENGINE = _Liggghts()
command, run, read_log = ENGINE.command, ENGINE.run, ENGINE.read_log
