"""Programs of the headers, compiled."""

import subprocess
from pathlib import Path

import demlaws as dl

HEADERS = Path(dl.__file__).parent / "cpp"


def compiled(folder, source, *flags):
    """Path of the program that is compiled in `folder` from a C++ file of this folder, or from one with its own path."""
    program = folder / Path(source).stem
    command = ["g++", "-std=c++11", "-O2", "-I", HEADERS, Path(__file__).parent / source, "-o", program, *flags]
    subprocess.run(list(map(str, command)), check=True)
    return program
