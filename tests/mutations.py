#!/usr/bin/env python3
"""Mutation test: change one number or one condition of the package at a time and check that its tests notice.

    python tests/mutations.py                           # all mutations: some twenty minutes on one core
    python tests/mutations.py --only rms --only E*      # those whose names contain one of these texts
    python tests/mutations.py --jobs 2 --out mutations.txt
    python tests/mutations.py --list                    # the mutations, after a check that each matches its source

Most mutations are 2 % of a coefficient, an exponent or a factor; the last group changes logic. Each names a source file, the
changed expression in its context and the tests that must fail. Files and tests are looked up by name, so that a file may move
to another folder. A mutation whose expression is not found exactly once is an error, reported before any test runs.

Every test runs in a temporary copy of the working tree; the tree itself is never changed. Tests that failed under a mutation
are repeated without it: a test that fails there, too, has caught nothing. Exit status: 0 if every mutation was caught, else 1.
"""

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

PROJECT = Path(__file__).resolve().parents[1]
TIME_LIMIT = 900  # [s] per mutation; a mutation whose tests do not end has been noticed
CHANGE = re.compile(r"<<(.*?) -> (.*?)>>", re.S)


class Mutation(NamedTuple):
    """One change of the package."""

    name: str
    file: str  # pattern of the end of the path; one file that fits it must hold the expressions
    edits: tuple  # expressions with the change marked as <<old -> new>>; blanks stand for any white space or none
    tests: str  # test files by name, then options of pytest


def _m(name, file, *edits, tests):
    return Mutation(name, file, edits, tests)


EXACT, HERTZ, RMS, POHRT = "test_exactness.py", "test_hertz.py", "test_rms.py", "test_pohrt_popov.py"
PLASTIC = "test_literature.py -k {}"
UNLOADING = "test_unloading.py -k 'hertz and not asperity and not greenwood and not yip'"

MUTATIONS = (
    # --- contact: sums and parameters
    _m(
        "E* sum",
        "demlaws/contact.py",
        "modulus=1.0 / (1.0 / material1.plane_modulus + <<1.0 -> 1.02>> / material2.plane_modulus)",
        tests="tests/test_contact.py",
    ),
    _m(
        "plane modulus 1 - ν²",
        "demlaws/contact.py",
        "self.young / (1.0 - <<self.poisson**2 -> 1.02 * self.poisson**2>>)",
        tests="tests/test_contact.py",
    ),
    _m(
        "R sum", "demlaws/contact.py", "radius=1.0 / (1.0 / radius1 + <<1.0 -> 1.02>> / radius2)", tests="tests/test_contact.py"
    ),
    _m(
        "σ sum",
        "demlaws/contact.py",
        "roughness=np.hypot(roughness1, <<roughness2 -> 1.02 * roughness2>>)",
        tests=EXACT,
    ),
    _m(
        "α factor 16",
        "demlaws/contact.py",
        "self.roughness * (<<16.0 -> 16.32>> * self.radius",
        tests="tests/test_contact.py test_hertz.py",
    ),
    # --- Hertz
    _m("hertz coefficient 4/3", "core/hertz.py", "return <<4.0 -> 4.08>> * modulus * sqrt(radius) / 3.0", tests=HERTZ),
    _m("hertz overlap of a force", "core/hertz.py", "return <<root -> 1.02 * root>> * root", tests=HERTZ),
    _m("hertz stiffness 1.5", "laws/hertz.py", "return stiffness * overlap, <<1.5 -> 1.53>> * stiffness", tests=HERTZ),
    _m("hertz energy 0.4", "laws/hertz.py", "return <<0.4 -> 0.408>> * p.hertz_coefficient", tests=HERTZ),
    # --- rms
    _m(
        "rms 2.4",
        "laws/rms.py",
        "a = <<4.8 -> 4.896>> - v",
        "b = <<5.76 -> 5.992704>> - (v + v)",
        "ratio = (<<2.4 -> 2.448>> + 2.0 * s) / (1.0 + 2.0 * s) return",
        tests=RMS,
    ),
    _m("rms energy 5.6", "laws/rms.py", "<<5.6 -> 5.712>> * first", tests=RMS),
    # --- Pohrt & Popov
    _m("pohrt-popov exponent 0.2567", "laws/pohrt_popov.py", 'm = np.longdouble("<<0.2567 -> 0.2618>>")', tests=POHRT),
    _m("pohrt-popov threshold 20", "laws/pohrt_popov.py", "(<<20 -> 20.4>> / (root_pi**3 * dimension))", tests=POHRT),
    _m("pohrt-popov energy exponent 1.5", "laws/pohrt_popov.py", "exponent = <<1.5 -> 1.53>> * ratio + 1.0", tests=POHRT),
    # --- Goddard
    _m(
        "goddard threshold 3π²/16",
        "laws/goddard.py",
        "GoddardShape(<<3.0 -> 3.06>> * math.pi**2 / 16.0",
        tests="test_goddard.py",
    ),
    _m(
        "goddard equivalent 3/4", "laws/goddard.py", "equivalent = <<0.75 -> 0.765>> * overlap * slope", tests="test_goddard.py"
    ),
    # --- rough-plastic
    _m(
        "rough-plastic yield stiffness",
        "laws/rough_plastic.py",
        "stiffness = <<math.pi -> 1.02 * math.pi>> * radius * shape.yield_pressure",
        tests="test_rough_plastic.py",
    ),
    _m(
        "rough-plastic yield load π³/6",
        "laws/rough_plastic.py",
        "math.pi**3 / <<6.0 -> 6.12>> * pressure",
        tests="test_rough_plastic.py",
    ),
    _m(
        "rough-plastic contact area",
        "laws/rough_plastic.py",
        "p.yield_area + <<p.area_slope -> 1.02 * p.area_slope>> * (yielded",
        tests="test_rough_plastic.py",
    ),
    # --- Bahrami
    _m(
        "bahrami 4.79",
        "laws/bahrami.py",
        "d = <<4.79 -> 4.8858>> - 3.17 * high * p q = root / d",
        "d = <<4.79 -> 4.8858>> - 3.17 * high * p c = 8.0",
        tests="test_bahrami.py",
    ),
    _m("bahrami 1.22", "laws/bahrami.py", "softness = <<1.22 -> 1.2444>> * kappa**-0.16", tests="test_bahrami.py"),
    _m("bahrami exponent -0.16", "laws/bahrami.py", "softness = 1.22 * kappa**<<-0.16 -> -0.1632>>", tests="test_bahrami.py"),
    _m("bahrami 3.51", "laws/bahrami.py", "a = <<3.51 -> 3.5802>> - 2.51 * p", tests="test_bahrami.py"),
    # --- solved layers
    _m(
        "yip-venart number √8",
        "laws/yip_venart.py",
        "CurveNumber(math.sqrt(<<8.0 -> 8.32>>) * contact.hardness",
        tests="test_yip_venart.py",
    ),
    _m(
        "yip-venart layer ½ erfc",
        "solvers/*.py",
        "return <<0.5 -> 0.51>> * erfc(s / math.sqrt(2)), <<-phi -> -1.02 * phi>>, <<s -> 1.02 * s>> * phi",
        "return <<phi -> 1.02 * phi>> * (1 - d * mills), <<phi -> 1.02 * phi>> * mills, <<-phi -> -1.02 * phi>>",
        tests="test_axisymmetric.py -k 'pressures or independent'",
    ),
    _m(
        "greenwood-tripp layer 3/2",
        "solvers/*.py",
        "return <<f32 -> 1.02 * f32>>, <<-1.5 -> -1.53>> * f12, <<0.75 -> 0.765>> * fm12",
        tests="test_axisymmetric.py -k 'pressures or independent'",
    ),
    _m(
        "greenwood-tripp μ 8/3",
        "laws/greenwood_tripp.py",
        "CurveNumber(<<8.0 -> 8.16>> / 3.0 * density",
        tests="test_greenwood_tripp.py",
    ),
    # --- measured maps
    _m(
        "asperity K_ν 0.4645",
        "solvers/*.py",
        "return <<0.4645 -> 0.4738>> + 0.3141 * poisson",
        tests="solvers/test_contact.py test_exactness.py -k 'yield or residual'",
    ),
    _m(
        "asperity elastic force 4√2/3",
        "solvers/*.py",
        "elastic_force = <<4.0 -> 4.08>> * math.sqrt(2.0) / 3.0 * p.modulus",
        tests="solvers/test_contact.py -k circular",
    ),
    _m(
        "asperity first yield π²/2",
        "solvers/*.py",
        "first = <<0.5 -> 0.51>> * math.pi * math.pi * mean_radius",
        tests="solvers/test_contact.py -k 'yield or joints'",
    ),
    _m(
        "asperity plastic area 2π",
        "solvers/*.py",
        "plastic_area = <<2.0 -> 2.04>> * math.pi * geometric_radius",
        tests="solvers/test_contact.py -k 'yield or joints'",
    ),
    _m(
        "asperity area between yield and flow",
        "solvers/*.py",
        "x * x * (<<3.0 - 2.0 -> 3.06 - 2.06>> * x)",
        tests=EXACT,
    ),
    # --- plastic spheres
    _m(
        "thornton-ning π/2",
        "laws/thornton_ning.py",
        "ratio = <<0.5 -> 0.51>> * math.pi * shape.yield_pressure",
        tests=PLASTIC.format("thornton-ning"),
    ),
    _m(
        "conical-damage h π/2",
        "laws/conical_damage.py",
        "ratio = <<0.5 -> 0.51>> * math.pi * shape.strength",
        tests=PLASTIC.format("conical-damage"),
    ),
    _m(
        "conical-damage growth",
        "laws/conical_damage.py",
        "<<1.0 -> 1.02>> / (radius * (h + shape.blunting))",
        tests=PLASTIC.format("conical-damage"),
    ),
    _m(
        "walton-braun k2/k1",
        "laws/walton_braun.py",
        "first, growth = <<shape.stiffness_ratio -> 1.02 * shape.stiffness_ratio>> * k1",
        tests="test_walton_braun.py",
    ),
    _m(
        "luding limit 2R", "laws/luding.py", "shape.plasticity_depth * <<2.0 -> 2.04>> * radius", tests=PLASTIC.format("luding")
    ),
    _m(
        "eepa plastic overlap",
        "laws/eepa.py",
        "cbrt(1.0 - <<1.0 -> 1.02>> / shape.stiffness_ratio)",
        tests=PLASTIC.format("eepa"),
    ),
    _m(
        "kogut-etsion 1.03",
        "laws/kogut_etsion.py",
        "_FACTOR2, _POWER2 = <<1.03 -> 1.0506>>, 1.425",
        tests=PLASTIC.format("kogut-etsion"),
    ),
    _m(
        "kogut-etsion 1.263",
        "laws/kogut_etsion.py",
        "_FACTOR2, _POWER2 = 1.03, 1.425, 1.40, <<1.263 -> 1.288>>",
        tests=PLASTIC.format("kogut-etsion"),
    ),
    _m(
        "kogut-etsion area 0.94",
        "laws/kogut_etsion.py",
        "_AREA, _AREA_POWER = <<0.94 -> 0.9588>>",
        tests=PLASTIC.format("kogut-etsion"),
    ),
    _m(
        "kogut-etsion K 0.454",
        "laws/kogut_etsion.py",
        "return (<<0.454 -> 0.463>> + 0.41 * poisson) * 2.8",
        tests=PLASTIC.format("kogut-etsion"),
    ),
    _m(
        "jackson-green C 1.295",
        "laws/jackson_green.py",
        "<<1.295 -> 1.321>> * math.exp(0.736 * ratio)",
        tests=PLASTIC.format("jackson-green"),
    ),
    _m("jackson-green radius 1.9", "laws/jackson_green.py", "_YIELD = <<1.9 -> 1.938>>", tests=PLASTIC.format("jackson-green")),
    _m(
        "jackson-green exponent 5/12",
        "laws/jackson_green.py",
        "bulk = exp2(<<(5.0 / 12.0) -> 0.425>> * logarithm)",
        tests=PLASTIC.format("jackson-green"),
    ),
    _m(
        "jackson-green exponent 0.7",
        "laws/jackson_green.py",
        "exp2(<<-0.7 -> -0.714>> * (p.radius_logarithm",
        tests=PLASTIC.format("jackson-green"),
    ),
    _m("conical-damage energy", "laws/conical_damage.py", "x * x / <<3.0 -> 3.06>>", tests=PLASTIC.format("conical-damage")),
    # --- unloading rules and shear
    _m(
        "rule hertz radius + 6 %",
        "*.py",
        "maximum, plastic = overlap, overlap - <<hertz_overlap -> hertz_overlap / 1.06 ** (1.0 / 3.0)>>",
        "root = p.hertz_coefficient * sqrt(<<elastic -> 1.06 * elastic>>)",
        "return _balance(p, <<p.hertz_coefficient -> p.hertz_coefficient * sqrt(1.06)>>, overlap, state)",
        "root = cbrt(force / <<p.hertz_coefficient -> (p.hertz_coefficient * sqrt(1.06))>>) return state[1] + root * root "
        "@kernel def thornton_step",
        tests=EXACT,
    ),
    _m(
        "rule thornton radius",
        "*.py",
        "ratio = <<growth -> 1.02 * growth>> * sqrt(growth)",
        tests=EXACT,
    ),
    _m("rule hertz energy 0.4", "*.py", "return <<0.4 -> 0.408>> * coefficient * elastic", tests=EXACT),
    _m(
        "shear 1.5 of the recoverable overlap",
        "*.py",
        "return <<1.5 -> 1.53>> * force / elastic",
        tests=EXACT,
    ),
    _m(
        "shear 1.5 of the force",
        "*.py",
        "return <<1.5 -> 1.53>> * cbrt(coefficient",
        tests=EXACT,
    ),
    _m(
        "shear force kept where the stiffness rises",
        "core/slip.py",
        "u, v = u * (held / top), v * (held / <<top -> (1.02 * top)>>)",
        tests="test_partial_slip.py",
    ),
    _m(
        "friction of a spring",
        "core/slip.py",
        "friction * compression[k] * <<scale -> (1.02 * scale)>> / ratio",
        tests="test_partial_slip.py",
    ),
    _m(
        "YADE share of the shear force",
        "yade/*.py",
        "return <<now / old -> 0.98 * now / old>> if now < old",
        tests="test_yade_shear.py",
    ),
    _m(
        "softening of roughness 2/3",
        "*.py",
        'Contact: {"radius": 0.0, "modulus": -1.0, "roughness": <<2 / 3 -> 1 / 3>>',
        tests="test_soften.py",
    ),
    # --- tables
    _m(
        "table stiffness",
        "*.py",
        "slope = (c1 + t * (<<2.0 -> 2.04>> * c2 + t * (3.0 * c3))) * inverse_width return",
        tests="test_table.py -k certificate",
    ),
    _m(
        "table contact area after yield",
        "*.py",
        "more = <<bulk.slope -> 1.02 * bulk.slope>> *",
        tests="test_table.py -k thornton",
    ),
    _m(
        "C++ thornton radius",
        "cpp/demlaws_table.h",
        "state[2] = <<1. -> 1.02>> / (ratio * sqrt(ratio))",
        tests="test_table_header.py test_golden_tables.py",
    ),
    _m(
        "C++ shear 1.5",
        "cpp/demlaws_table.h",
        "return <<1.5 -> 1.53>> * now.force / recoverable",
        tests="test_golden_tables.py",
    ),
    _m(
        "table energy below the first row",
        "core/grid.py",
        "u[0] / (<<1.5 -> 1.53>> * exponent + 1.0)",
        tests="test_table.py -k energy",
    ),
    _m(
        "table contact radius of rule etsion",
        "laws/etsion.py",
        "exp2(<<p.power -> 1.02 * p.power>> * log2(ratio",
        tests="test_table.py test_golden_tables.py -k 'etsion or jackson or kogut'",
    ),
    _m(
        "C++ unloading energy 8/15",
        "cpp/demlaws_table.h",
        "hertz = (<<8. -> 8.16>> / 15.) * pair.modulus",
        tests="test_table_header.py",
    ),
    _m(
        "C++ eepa energy",
        "cpp/demlaws_table.h",
        "a * a * (2. * a + <<4. -> 4.08>> * b)",
        tests="test_table_header.py test_golden_tables.py",
    ),
    _m(
        "C++ contact area after yield",
        "cpp/demlaws_table.h",
        "sqrt(yield_s_)) * <<yield_area_slope_ -> 1.02 * yield_area_slope_>>;",
        tests="test_table_header.py test_golden_tables.py",
    ),
    # --- criterion and time step
    _m(
        "criterion p0 factor 6",
        "*.py",
        "return (<<6.0 -> 6.12>> * np.asarray(load, float)",
        tests=EXACT,
    ),
    _m(
        "criterion exponent 0.6 of α",
        "*.py",
        "-np.expm1(-2.0 / (3.0 * alpha**<<0.6 -> 0.612>>))",
        tests=EXACT,
    ),
    _m(
        "criterion roughness of transition",
        "*.py",
        "np.minimum(share, 1.0)))) ** <<(1 / 0.6) -> (1 / 0.612)>>",
        tests="test_regime.py",
    ),
    _m("criterion p(0)/H_m 0.6", "*.py", "YIELD_RATIO = <<0.6 -> 0.612>>", tests=EXACT),
    _m(
        "time-step limit of a pair",
        "timestep.py",
        "return <<2.0 -> 2.04>> / math.sqrt(stiffness * (1.0 / mass1",
        tests="test_timestep.py -k 'pair or shear_ratio'",
    ),
    _m(
        "time-step limit of a pair, 7/2",
        "timestep.py",
        "max(1.0, <<3.5 -> 3.57>> * ratio)",
        tests="test_timestep.py -k 'pair or shear_ratio'",
    ),
    _m(
        "time-step limit of a packing, 2/3",
        "timestep.py",
        "<<2.0 -> 2.04>> / 3.0 * contacts",
        tests=EXACT,
    ),
    _m(
        "shear ratio of two materials",
        "timestep.py",
        "<<2.0 -> 2.04>> * (2.0 - m.poisson)",
        tests="test_timestep.py -k 'pair or shear_ratio'",
    ),
    _m(
        "Rayleigh step 0.8766",
        "timestep.py",
        "0.1631 * poisson + <<0.8766 -> 0.8941>>",
        tests="test_timestep.py -k 'pair or shear_ratio'",
    ),
    _m(
        "STEP_SAFETY 0.8",
        "timestep.py",
        'STEP_SAFETY = <<0.8 -> 0.95>> """Safety',
        tests=EXACT,
    ),
    _m(
        "SOFTENING_SAFETY 0.56",
        "timestep.py",
        "SOFTENING_SAFETY = <<0.56 -> 0.5712>>",
        tests=EXACT,
    ),
    _m(
        "velocity Verlet ½",
        "*.py",
        "velocity -= <<0.5 -> 0.51>> * dt * force / mass overlap += dt * velocity",
        tests="test_driver.py -k impact",
    ),
    # --- logic
    _m(
        "pohrt-popov branch",
        "laws/pohrt_popov.py",
        "slope = power(relative, p.ratio - 1.0) if relative << < -> > >> 1.0: return overlap",
        tests=POHRT,
    ),
    _m(
        "luding stiffness without its limit",
        "linear_unloading.py",
        "return k2 if k2 << <= -> >= >> own.largest_stiffness else own.largest_stiffness",
        tests=PLASTIC.format("luding"),
    ),
    _m(
        "rule hertz keeps its state after separation",
        "*.py",
        "1.5 * root if overlap <= 0.0: "
        "force, stiffness, maximum, plastic = <<0.0, 0.0, 0.0, 0.0 -> 0.0, 0.0, maximum, plastic>> "
        "return force, stiffness, (maximum, plastic) @kernel def _hertz_energy",
        tests=UNLOADING,
    ),
    _m(
        "eepa forgets its largest overlap",
        "laws/eepa.py",
        "maximum, plastic = <<state -> overlap, state[1]>> elastic = root * positive",
        tests=PLASTIC.format("eepa"),
    ),
    _m(
        "conical-damage sign",
        "laws/conical_damage.py",
        "ratio = 1.0 << + -> - >> p.growth",
        tests=PLASTIC.format("conical-damage"),
    ),
)


def source_of(tree, mutation):
    """(path, new text) of the only source file that fits the pattern of a mutation and in which it can be made."""
    found, reasons = [], []
    for path in sorted(path for path in (tree / "demlaws").rglob("*.*") if path.match(mutation.file)):
        try:
            found.append((path, mutated(path.read_text(), mutation.edits)))
        except LookupError as error:
            reasons.append(str(error))
    if len(found) != 1:
        raise LookupError(f"{mutation.file}: " + (reasons[0] if len(reasons) == 1 else f"{len(found)} files fit"))
    return found[0]


def mutated(text, edits):
    """The text with every edit made; LookupError where an edit does not match exactly once."""
    for edit in edits:
        parts = CHANGE.split(edit)  # context, old, new, context, …
        pattern, new = "", []
        for n, part in enumerate(parts):
            if n % 3 == 2:
                new.append(part.strip())
            else:
                pattern += "(" + r"\s*".join(re.escape(word) for word in re.split(r"\s+", part)) + ")"
        matches = list(re.finditer(pattern, text))
        if len(matches) != 1 or not new:
            raise LookupError(f"{len(matches)} matches of: {edit}")
        (match,) = matches
        pieces = list(match.groups())
        pieces[1::2] = new
        text = text[: match.start()] + "".join(pieces) + text[match.end() :]
    return text


def arguments_of(tree, tests):
    """The arguments of pytest, with the path of every test file."""
    arguments = []
    for word in shlex.split(tests):
        found = [path for path in (tree / "tests").rglob("*.py") if path.match(word)] if word.endswith(".py") else [word]
        if len(found) != 1:
            raise LookupError(f"{len(found)} test files are called {word}")
        arguments.append(str(found[0]))
    return arguments


def problem_of(mutation):
    """Why a mutation cannot be made in the working tree, or None."""
    try:
        arguments_of(PROJECT, mutation.tests)
        source_of(PROJECT, mutation)
    except LookupError as error:
        return f"{mutation.name}: {error}"
    return None


class Tree:
    """A temporary copy of the working tree in which one process at a time runs tests."""

    def __init__(self, folder):
        listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
        names = subprocess.run(listed, cwd=PROJECT, capture_output=True, text=True, check=True).stdout.split("\0")
        for name in names:
            if name and (PROJECT / name).is_file():
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(PROJECT / name, folder / name)
        self.path = folder
        self.edits = 0

    def pytest(self, *arguments):
        """Exit status and output of pytest in this tree."""
        environment = {**os.environ, "PYTHONPATH": str(self.path), "NUMBA_CACHE_DIR": str(self.path.parent / "numba")}
        environment.pop("CI", None)
        command = [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "--tb=no", "-rfE", "-m", "not slow"]
        command += ["-p", "no:cacheprovider", "--hypothesis-seed=0", *arguments]
        try:
            ran = subprocess.run(
                command, cwd=self.path, env=environment, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
            )
        except subprocess.TimeoutExpired:
            return 1, "FAILED time limit"
        return ran.returncode, ran.stdout + ran.stderr

    def try_mutation(self, mutation):
        """(what failed or None, seconds) of the tests of a mutation."""
        (source, changed), began = source_of(self.path, mutation), time.monotonic()
        original = source.read_text()
        try:
            self._write(source, changed)
            status, output = self.pytest(*arguments_of(self.path, mutation.tests))
        finally:
            self._write(source, original)
        failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.M)
        if status not in (0, 1, 2) or (status and not failed):
            raise RuntimeError(f"{mutation.name}: pytest ended with {status}:\n{output[-2000:]}")
        return (failed.group(1) if status else None), time.monotonic() - began

    def _write(self, source, text):
        """Write a source file with a time stamp of its own, so that no compiled file of Python is taken for current."""
        source.write_text(text)
        self.edits += 2
        os.utime(source, (time.time() + self.edits, time.time() + self.edits))


def run(mutations, jobs, write):
    """Try the mutations; returns what failed by mutation (None: it survived)."""
    failures = {}
    with tempfile.TemporaryDirectory(prefix="mutations-") as folder:
        trees = [Tree(Path(folder, f"tree{n}")) for n in range(jobs)]
        free, lock = list(trees), threading.Lock()

        def work(mutation):
            with lock:
                tree = free.pop()
            try:
                failed, seconds = tree.try_mutation(mutation)
            finally:
                with lock:
                    free.append(tree)
            with lock:
                failures[mutation.name] = failed
                write(f"{'survived' if failed is None else 'caught':9}{mutation.name:45}{seconds:6.0f} s  {failed or ''}")

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(work, mutations))
        tests = sorted({failed for failed in failures.values() if failed and "::" in failed})
        if tests:  # without -x: every test that fails without a mutation is to be named
            _, output = trees[0].pytest("--maxfail=1000", *tests)
            for test in re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", output, re.M):
                write(f"fails without a mutation: {test}")
                failures.update((name, None) for name, failed in failures.items() if failed == test)
    return failures


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="TEXT", help="mutations whose name contains TEXT; may be repeated")
    parser.add_argument("--jobs", type=int, default=1, help="mutations tried at the same time (default: 1)")
    parser.add_argument("--out", metavar="FILE", help="also write the table to FILE")
    parser.add_argument("--list", action="store_true", help="list the mutations and check that each can be made")
    options = parser.parse_args(arguments)
    chosen = [m for m in MUTATIONS if not options.only or any(text in m.name for text in options.only)]
    problems = [problem for problem in map(problem_of, chosen) if problem]
    if problems or not chosen:
        print("\n".join(problems) or "no mutation has such a name", file=sys.stderr)
        return 1
    if options.list:
        print("\n".join(f"{mutation.name:45}{mutation.file}" for mutation in chosen))
        return 0
    lines = []

    def write(line):
        lines.append(line)
        print(line, flush=True)
        if options.out:
            Path(options.out).write_text("\n".join(lines) + "\n")

    failures = run(chosen, max(options.jobs, 1), write)
    survivors = [name for name, failed in failures.items() if failed is None]
    write(f"{len(failures) - len(survivors)} of {len(failures)} mutations caught")
    if survivors:
        write(f"survived: {', '.join(survivors)}")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
