"""One default of unloading: of dl.law, commands, cases of LIGGGHTS and LAMMPS, YADE; the first line of outputs has it."""

import pytest
from examples import GRANITE, options_of, quiet

import demlaws as dl
from demlaws.cli import main
from demlaws.laws.registry import find
from demlaws.plugins.grains import Case, Grain
from demlaws.yade.pairs import LawSource

CONTACT = ["--effective-radius", "4mm", "--modulus", "32GPa", "--sigma", "2um", "--fractal-dimension", "2.2"]
CONTACT += ["--hardness", "6.266GPa"]
OWN = {"thornton-ning": "thornton", "conical-damage": "thornton", "jackson-green": "etsion", "kogut-etsion": "etsion"}
OWN |= {"walton-braun": "linear", "luding": "linear", "eepa": "eepa"}


def wanted(law):
    """Hertz's for rough contacts that take it, the law's own, else elastic."""
    rough = "sigma" in find(law).needed(**options_of(law)) or find(law).needs_map
    if law in OWN or not rough:
        return OWN.get(law, "elastic")
    try:
        quiet(dl.law, law, GRANITE, "hertz", **options_of(law))
    except dl.errors.NotPassive:
        return "elastic"
    return "hertz"


@pytest.mark.parametrize("law", dl.laws())
def test_one_default(law, capsys):
    rule, options = wanted(law), options_of(law)
    assert find(law).default_rule(**options) == quiet(dl.law, law, GRANITE, **options).unloading == rule
    stone = dl.Material(60.6e9, 0.25, 6.266e9, surface=dl.Surface(1e-6, 2.2))
    assert Case(law, (Grain(4e-3, stone),), options=options).unloading == LawSource(law, options).unloading == rule
    if find(law).needs_map:
        return
    words = [f"--option={name}={value!r}" for name, value in options.items() if isinstance(value, float)]
    assert main(["curve", "--law", law, *CONTACT, *words, "--overlaps", "1e-6", "--steps", "1"]) == 0
    assert capsys.readouterr().out.startswith(f"{law}, {rule} unloading; contact: ")


def test_the_default_of_options():
    """What cannot take Hertz's is elastic."""
    assert find("rough-plastic").default_rule() == find("rough-plastic").default_rule(loading="rms") == "hertz"
    assert find("rough-plastic").default_rule(loading="bahrami") == "elastic"


def test_a_curve_to_unload_along_needs_no_rule():
    """A law with its default rule, and its table, as with elastic."""
    worn = dl.law("pohrt-popov", GRANITE.with_values(sigma=1e-6))
    law = dl.law("pohrt-popov", GRANITE, worn)
    assert law.unloading == "table" and law == dl.law("pohrt-popov", GRANITE, worn.joined("elastic"))
    with pytest.raises(dl.DemlawsError):
        dl.law("pohrt-popov", GRANITE, worn.joined("thornton"))


@pytest.mark.parametrize("engine", ["liggghts", "lammps"])
def test_outputs_begin_with_the_rule(engine, tmp_path, capsys):
    grains = ["--radius", "4mm", "--roughness", "1um", "--fractal-dimension", "2.2", "--count", "3"]
    assert main([engine, "export", str(tmp_path / "case"), "--law", "pohrt-popov", *grains, "--rtol", "1e-2"]) == 0
    assert "law pohrt-popov, hertz unloading" in capsys.readouterr().out.splitlines()[0]
    file = str(tmp_path / "law.tbl")
    table = ["table", "--law", "pohrt-popov", *CONTACT, "--rtol", "1e-2", "--max-force", "10N", "--out", file]
    assert main(table) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("pohrt-popov, hertz unloading; contact: ") and dl.Table.load(file).unloading == "hertz"
    assert "with a tenth of this R" in printed  # where the table ends for smaller grains
