"""Typical mistakes on the command line: the message names the value and the remedy."""

import warnings

import pytest

from demlaws.cli import main

CONTACT = "--radius 8mm 8mm --young 60.6GPa --poisson 0.25 --roughness 1.7um --fractal-dimension 2.22"
FILES = {
    "below.csv": "displacement (um),force (N)\n" + "".join(f"{i},-{i}\n" for i in range(1, 9)),
    "notes.txt": "radii\n",
    "typo.toml": "radiis = 1e-3\nforce = 1\n",
    "material.toml": "radii = 1e-3\n[material]\nyung = 1\n",
    "number.toml": "radii = 1e-3\nmaterial = 3\n",
    "long.toml": f"radii = {'1' * 5000}\n",
    "deep.toml": f"radii = {'[' * 5000}\n",
    "rough.toml": "radii = [5e-3, 5e-3]\nforce = [50.0, 100.0]\nquantity = 'overlap'\n[material]\nyoung = 60e9\npoisson = 0.2\n"
    "[surface]\nroughness = 4e-4\nfractal_dimension = 2.2\n",
}
MISTAKES = [
    (
        "curve --law rough-plastic --material granite --option yieldpressure=1GPa --forces 1 --radius 8mm 8mm",
        ["'yieldpressure'", "did you mean 'yield_pressure'"],
    ),
    ("choose typo.toml", ["typo.toml: a scene has no key 'radiis', did you mean 'radii'"]),
    ("choose material.toml", ["material.toml: [material] has no key 'yung', did you mean 'young'"]),
    ("choose number.toml", ["number.toml: [material] must have lines key = value"]),
    ("choose long.toml", ["long.toml"]),
    ("choose deep.toml", ["deep.toml"]),
    (
        "curve --law hertz --radius 8mm --modulus 30GPa --forces 1",
        ["--radius 8mm flat for a sphere on a flat", "--radius 8mm 8mm for two equal", "--effective-radius"],
    ),
    ("curve --law hertz --radius flat flat --modulus 30GPa --forces 1", ["--radius = flat: two flats"]),
    ("curve --law hertz --radius 8mm 0 --modulus 30GPa --forces 1", ["--radius = 0 m: a radius must be positive"]),
    ("curve --law hertz --radius 8mm 8 --modulus 30GPa --forces 1", ["--radius = 8 m is above 1 m"]),
    ("curve --law rms --radius 8mm 8mm --modulus 30GPa --roughness 1.7 --forces 1", ["--roughness = 1.7 m is 425 times"]),
    ("curve --law rms --test SS(18-18) --roughness 5mm --forces 1", ["--roughness = 5mm is 1.15 times"]),
    ("curve --law hertz --radius 8mm 8mm --material marble --forces 1", ["'marble'", "granite, glass"]),
    ("curve --law hertz --radius 8mm 8mm --material ballast --forces 1", ["no typical values of 'ballast'. Materials:"]),
    ("curve --law hertz --test SS(18-18) --material glass --forces 1", ["either --material or --test"]),
    ("lammps export case --radius 1mm 2mm 3mm --material glass steel", ["--material has 2 values for 3 radii"]),
    (f"soften --factor 0.1 --law hertz {CONTACT}", ["0.1", "1 or more"]),
    (f"curve --law eepa {CONTACT} --forces 10", ["stiffness_ratio=VALUE"]),
    (f"curve --law conical-damage {CONTACT} --forces 10", ["strength=VALUE", "angle=VALUE"]),
    (f"curve --law rough-plastic {CONTACT} --forces 10", ["yield_pressure=VALUE"]),
    (f"curve --law hertz {CONTACT} --forces 10 --option softness=3", ["has no options", "'softness'"]),
    (
        "curve --law pohrt-popov --radius 8mm 8mm --young 60GPa --poisson 0.2 --forces 1",
        ["(--roughness), 0 for smooth"],
    ),
    (
        "curve --law pohrt-popov --radius 8mm 8mm --roughness 1um --young 60GPa --poisson 0.2 --forces 1",
        ["give fractal_dimension (--fractal-dimension)\n"],
    ),
    ("curve --law hertz --radius 8mm 8mm --young=-60GPa --poisson 0.2 --forces 1", ["young = -60GPa", "positive"]),
    ("curve --law hertz --effective-radius=-8mm --modulus 30GPa --forces 1", ["error: radius = -8mm", "positive"]),
    ("curve --law hertz --radius 8mm 8mm --modulus 30GPa --fractal-dimension 5 --forces 1", ["fractal_dimension = 5:"]),
    ("regime --radius 8mm 8mm --modulus 30GPa --roughness 1um --hardness 6Pa", ["hardness = 6Pa", "units"]),
    (f"curve --law rough-plastic {CONTACT} --forces 10 --option yield_pressure=-2GPa", ["yield_pressure = -2GPa: must"]),
    (f"curve --law hertz {CONTACT} --overlaps 1um 1cm", ["overlap 1cm is "]),
    ("curve --law hertz --radius 8mm 8mm --modulus 30GPa --forces 1 1e9kN", ["force = 1e9kN is too large for this contact"]),
    ("regime --radius 8mm 8mm --modulus 30GPa --hardness 6GPa --roughness 0 --load 1e9kN", ["load 1e9kN: overlap"]),
    ("curve --law hertz --radius 8mm --modulus 30GPa --forces 1", ["--radius 8mm 8mm for two"]),
    ("regime --radius 8mm 8mm --modulus 30GPa --roughness 50mm --hardness 6GPa", ["--roughness = 50mm is"]),
    ("fit below.csv --test SS(18-18)", ["compression is positive", "sign"]),
    ("choose notes.txt", ["notes.txt", "scene", "--template"]),
]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of the mistakes, and main()'s own way of showing warnings undone."""
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    with warnings.catch_warnings():
        yield


@pytest.mark.parametrize(("line", "words"), MISTAKES, ids=lambda value: value if isinstance(value, str) else "")
def test_a_mistake_is_named_with_its_remedy(line, words, capsys):
    assert main(line.split()) == 2
    text = capsys.readouterr().err
    assert text.startswith("demlaws: error: ") and all(word in text for word in words), text


def test_a_warning_is_shown_once(capsys):
    assert main(["choose", "rough.toml"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert lines and len(lines) == len(set(lines))


def test_descriptions_are_wrapped_at_words(capsys):
    with pytest.raises(SystemExit):
        main(["timestep", "--help"])
    assert max(map(len, capsys.readouterr().out.split("example:")[0].splitlines())) <= 110
