"""What the inputs of LIGGGHTS and LAMMPS have in common: they are run, refused and compared alike."""

import importlib
import math

import numpy as np
import pytest

from demlaws.errors import DemlawsError

LOAD_UNLOAD = [(-0.2, 0, 1000), (0.2, 0, 600), (-0.2, 0, 800), (0.2, 0, 1800), (-0.2, 0, 800)]
ENERGY = {"more": "compute e all demlaws/energy", "columns": "c_e[1] c_e[2]"}


def part(engine, name):
    """A module of an engine: in its package, functions have the names of modules."""
    return importlib.import_module(f"demlaws.{engine}.{name}")


def moves_of(moves):
    """Lines that move the group `right`; moves: (speed along x, along y, steps)."""
    return "".join(f"velocity right set {along} {across} 0\nrun {steps}\n" for along, across, steps in moves)


def simulate(engine, folder, text, ranks=1, **options):
    (folder / "in.case").write_text(text)
    return part(engine, "run").run(folder / "in.case", ranks, **options)


def refused(engine, folder, text, ranks=1, **options):
    """Message of the engine's own error."""
    with pytest.raises(DemlawsError) as caught:
        simulate(engine, folder, text, ranks, **options)
    assert "ERROR" in str(caught.value)
    return str(caught.value)


def said_in(engine, folder):
    """Text of the log of a run."""
    return (folder / f"log.{engine}").read_text().replace("\n", " ")


def save(law, path, **options):
    law.tabulate(**options).save(path)
    return path.name


def error_of(log, law):
    expected = law.follow(log["overlap"]).force
    return np.abs(log["force"] - expected).max() / expected.max()


def energy_error_of(log, law):
    """Largest relative error of the force and of both columns of ENERGY."""
    path = law.follow(log["overlap"])
    pairs = (("force", path.force, path.force), ("e[1]", path.stored, path.work), ("e[2]", path.dissipated, path.work))
    return max(np.abs(log[name] - expected).max() / scale.max() for name, expected, scale in pairs)


def modulus(young=60.6e9, poisson=0.25):
    return young / (2 * (1 - poisson**2))


def sphere_mass(diameter):
    return 2650 * math.pi / 6 * diameter**3
