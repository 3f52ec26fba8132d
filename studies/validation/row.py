"""One row of the report: a number that somebody else wrote, and ours."""

import math
from typing import NamedTuple


class Row(NamedTuple):
    """A found value passes from `low` to `high`; `found` is NaN where the row could not be run, and `note` says why."""

    what: str
    where: str  # "Python" or the engine
    expected: str  # as printed
    low: float
    high: float
    found: float
    source: str  # key of SOURCES
    unit: str = ""
    note: str = ""

    @property
    def verdict(self):
        """pass, FAIL, or not run."""
        if math.isnan(self.found):
            return "not run"
        return "pass" if self.low <= self.found <= self.high else "FAIL"


def near(what, where, expected, found, tolerance, source, unit="", note=""):
    """A row that passes within a relative `tolerance` of `expected`."""
    width = abs(expected) * tolerance
    digits = 7 if tolerance > 1e-9 else 15
    return Row(
        what,
        where,
        f"{expected:.{digits}g} ± {tolerance:g}",
        expected - width,
        expected + width,
        float(found),
        source,
        unit,
        note,
    )


def between(what, where, low, high, found, source, unit="", note=""):
    """A row that passes from `low` to `high`."""
    return Row(what, where, f"{low:g} to {high:g}", low, high, float(found), source, unit, note)


def missing(what, where, expected, source, why):
    """A row that could not be run."""
    return Row(what, where, expected, math.nan, math.nan, math.nan, source, "", why)


MEASURED, CODES, PRINTED, EQUATIONS, METHODS = KINDS = (
    "Measured by others",
    "Computed by others' codes",
    "Printed in papers",
    "Our evaluation of printed equations",
    "Our other methods",
)
"""Whose answer a row is compared with, the strongest first."""


class Source(NamedTuple):
    """Who gave the answer, under what terms it is quoted, and whose answer it is (one of KINDS)."""

    text: str
    licence: str
    kind: str


FACTS = "numbers and formulas quoted as facts"
SOURCES = {
    "kharaz": Source("Kharaz, Gorham & Salman 2001, Powder Technology 120, 281: alumina spheres on glass", FACTS, MEASURED),
    "wu-thornton": Source(
        "finite elements quoted by Chung & Ooi 2011, test 5, as KratosMultiphysics keeps them "
        "(DEM3D_chung_ooi_tests/paper_data_5_to_8/benchmark5_graph2.dat)",
        "BSD-4-Clause: numbers quoted",
        CODES,
    ),
    "kratos": Source(
        "Chung & Ooi 2011, test 4, as KratosMultiphysics keeps it (DEM3D_chung_ooi_tests/test4_data/paper_data)",
        "BSD-4-Clause: numbers quoted",
        CODES,
    ),
    "kratos-spin": Source(
        "Chung & Ooi 2011, tests 6 to 8, as KratosMultiphysics keeps them (test_examples/basic_benchmarks/paper_data)",
        "BSD-4-Clause: numbers quoted",
        CODES,
    ),
    "thornton-2013": Source(
        "Thornton, Cummins & Cleary 2013, Powder Technology 233, 30, as KratosMultiphysics keeps it "
        "(test_examples/basic_benchmarks/paper_data/bench_10_norm_reb_ang_vel_e_090.dat)",
        "BSD-4-Clause: numbers quoted",
        CODES,
    ),
    "on-dem": Source(
        "ON-DEM, WG4-testingInteractions, output_ANA/theoretical_output_test_01, 02, 05 (1958efd, 23b4c1a): a linear law in "
        "imposed motions",
        "GPL-2.0: numbers quoted",
        CODES,
    ),
    "chung-ooi": Source("Chung & Ooi 2011, Granular Matter 13, 643: tests 1 to 3 (10.1007/s10035-011-0277-0)", FACTS, PRINTED),
    "lammps": Source(
        "LAMMPS 4Jul2026, unittest/granular: dem02-hertz-peak-3d-si, dem03-hertz-peak-wall-3d-si",
        "GPL-2.0: numbers quoted",
        CODES,
    ),
    "lammps-tests": Source("LAMMPS 4Jul2026, unittest/granular/tests (NAME-3d-si.yaml)", "GPL-2.0: numbers quoted", CODES),
    "thornton": Source("Thornton & Ning 1998, Powder Technology 99, 154 (10.1016/S0032-5910(98)00099-0)", FACTS, EQUATIONS),
    "duffy-mindlin": Source(
        "Duffy & Mindlin 1957, J. Appl. Mech. 24, 585; Walton 1987, J. Mech. Phys. Solids 35, 213", FACTS, EQUATIONS
    ),
    "gt-code": Source(
        "V. A. Yastrebov, Greenwood-Tripp-Model, run with 400 rings and Newton's method (github.com/vyastreb)",
        "BSD-3-Clause: results quoted",
        CODES,
    ),
    "gt-paper": Source("Greenwood & Tripp 1967, J. Appl. Mech. 34, 153, solved by an independent program", FACTS, METHODS),
    "yv-paper": Source("Yip & Venart 1971, J. Phys. D 4, 1470, solved by an independent program", FACTS, METHODS),
    "jamari": Source(
        "Jamari & Schipper 2006, Wear 262, 138: p(0)/p0 at α = 0.09 in the text, read from its Fig. 1", FACTS, PRINTED
    ),
    "granite": Source(
        "Altuhafi, Baudet & Coop 2023: equations and inputs of its tests, computed by an independent program", FACTS, METHODS
    ),
    "sneddon": Source("Sneddon 1965, Int. J. Eng. Sci. 3, 47: rigid cone; Johnson 1985, ch. 5", FACTS, EQUATIONS),
    "jackson-green": Source("Jackson & Green 2005, J. Tribol. 127, 343 (10.1115/1.1866166): finite elements", FACTS, EQUATIONS),
    "kogut-etsion": Source(
        "Kogut & Etsion 2002, J. Appl. Mech. 69, 657 (10.1115/1.1490373): finite elements", FACTS, EQUATIONS
    ),
    "conical-damage": Source(
        "Harkness et al. 2016, Granular Matter 18:65; Suhr & Six 2017, Granular Matter 19:64", FACTS, EQUATIONS
    ),
    "walton-braun": Source("Walton & Braun 1986, J. Rheol. 30, 949 (10.1122/1.549893)", FACTS, EQUATIONS),
    "luding": Source("Luding 2008, Granular Matter 10, 235 (10.1007/s10035-008-0099-x)", FACTS, EQUATIONS),
    "eepa": Source("Thakur et al. 2014, Granular Matter 16, 383 (10.1007/s10035-014-0506-4)", FACTS, EQUATIONS),
    "bem": Source(
        "ContactMechanics (L. Pastewka and others), elastic boundary elements", "MIT: results computed with it", CODES
    ),
    "sands": Source(
        "small-strain stiffness of sands ∝ pressure^0.5: Hardin & Richart 1963, J. Soil Mech. 89, 33", FACTS, MEASURED
    ),
}
