"""Materials, surfaces and contacts: derived quantities and input checks."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

import demlaws as dl
from demlaws.plugins.grains import Grain
from demlaws.units import UNITS, quantity

GRANITE = dl.Material(young=60.6e9, poisson=0.25, hardness=6.266e9)


def test_equal_contacts_have_one_hash():
    for radius in (4e-3, [1e-3, 2e-3]):
        one, other = (dl.Contact(radius, 32e9, 0.0, 2.2) for _ in "ab")
        assert one == other and hash(one) == hash(other)
        assert {one: 1}[other] == 1 and hash(one) != hash(one.with_values(modulus=33e9))
    assert hash(dl.Contact(4e-3, 32e9, 0.0)) == hash(dl.Contact(4e-3, 32e9, -0.0))


def test_flat_and_array_of_radii():
    flat = dl.Contact.between(GRANITE, GRANITE, radius1=6.05e-3, radius2="flat")
    assert flat.radius == 6.05e-3
    assert flat.size is None
    many = dl.Contact.between(GRANITE, GRANITE, radius1=np.array([1e-3, 2e-3, 4e-3]), radius2=2e-3)
    assert many.size == 3
    np.testing.assert_allclose(many.radius, [2 / 3e3, 1e-3, 4 / 3e3])


def test_both_radii_are_required():
    """A sphere on a flat is 41 % stiffer than two such spheres: which of them is meant is never assumed."""
    for radii in ({"radius1": "8mm"}, {"radius1": "8mm", "radius2": None}, {"radius1": None, "radius2": "8mm"}):
        with pytest.raises(dl.DemlawsError, match=r'radius. is missing: .* radius2="flat"'):
            dl.Contact.between(GRANITE, GRANITE, **radii)
    for flat in ("flat", " flat ", math.inf, "inf"):
        assert dl.Contact.between(GRANITE, GRANITE, radius1=flat, radius2="8mm").radius == 8e-3
    with pytest.raises(dl.DemlawsError, match="flat"):
        dl.Contact.between(GRANITE, GRANITE, radius1="flat", radius2="flat")


def test_a_rough_surface_is_named_as_it_was_given():
    radii = {"radius1": "8mm", "radius2": "8mm"}
    with pytest.raises(dl.DemlawsError, match=r"^roughness2 = 1\.7 m is 425 times the radius 0\.004 m"):
        dl.Contact.between(GRANITE, GRANITE, **radii, roughness1=1e-6, roughness2=1.7)
    with pytest.raises(dl.DemlawsError, match=r"^roughness1 = 0\.003 m is 0\.75 times"):
        dl.Contact.between(GRANITE, GRANITE, **radii, roughness1=[1e-6, 3e-3], roughness2=0)


@given(st.floats(1e-5, 1), st.floats(1e-5, 1), st.floats(0, 1e-7), st.floats(0, 1e-7))
def test_between_is_symmetric(radius1, radius2, roughness1, roughness2):
    other = dl.Material(young=200e9, poisson=0.3, hardness=2e9)
    a = dl.Contact.between(GRANITE, other, radius1=radius1, radius2=radius2, roughness1=roughness1, roughness2=roughness2)
    b = dl.Contact.between(other, GRANITE, radius1=radius2, radius2=radius1, roughness1=roughness2, roughness2=roughness1)
    assert vars(a) == pytest.approx(vars(b), nan_ok=True)
    assert a.hardness == 2e9
    assert a.radius <= min(radius1, radius2) * (1 + 1e-15)


def test_surface_combined():
    pair = dl.Surface(3e-6, 2.2, 5e9).combined(dl.Surface(4e-6, 2.3, 6e9))
    assert pair.roughness == pytest.approx(5e-6)
    assert pair.fractal_dimension == pytest.approx(2.25)
    assert pair.hardness == 5e9
    assert dl.Surface(3e-6, 2.2).combined(dl.Surface(0)) == dl.Surface(3e-6, 2.2, None)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: dl.Contact(1e-3, 1e9).with_values(radios=1e-3), "radios"),
        (lambda: dl.Material(young=1e9, poisson=0.6), "poisson"),
        # GPa for Pa, g/cm³ for kg/m³, mm for m
        (lambda: dl.Material(60.6, 0.25), "young = 60.6 Pa"),
        (lambda: dl.Material(60.6e9, 0.25, density=2.65), "density = 2.65 kg/m³"),
        (lambda: dl.Contact(radius=4e-3, modulus=32.32), "modulus = 32.32 Pa"),
        (lambda: dl.Contact(radius=[4e-3, 5e-3], modulus=32e9, sigma=3.4e-3), "sigma = 0.0034 m is 0.85"),
        (lambda: dl.Contact.between(GRANITE, GRANITE, radius1=8.76, radius2=8.63e-3), "radius1 = 8.76 m"),
        (lambda: dl.Contact.between(GRANITE, GRANITE, radius1=8.76e-3, radius2=np.array([8.63e-3, 8.63])), "radius2 = 8.63 m"),
        (lambda: dl.Surface(1e-6, fractal_dimension=1.9), "fractal_dimension"),
        (lambda: dl.Contact(radius=1e-3, modulus=1e9, sigma=2e-3), "sigma"),
        (lambda: dl.Contact(radius=[1e-3, -1e-3], modulus=1e9), "radius"),
        (lambda: dl.Contact(radius=[1e-3, 1e-3], modulus=[1e9] * 3), "modulus"),
        (lambda: dl.Contact(radius=1e-3, modulus=1e9, hardness=[1e9, 2e9]), "hardness"),
        # Vickers number and GPa in place of Pa
        (lambda: dl.Contact(radius=1e-3, modulus=[1e9, 32e9], hardness=640.0), "hardness"),
        (lambda: dl.Contact(radius=1e-3, modulus=[1e9, 32e9], hardness=6.266), "hardness"),
    ],
)
def test_bad_input_is_refused_by_field(make, field):
    """Each field's own limits: test_junk.py."""
    with pytest.raises(dl.DemlawsError) as error:
        make()
    assert field in str(error.value)


def test_contacts_are_compared_entry_by_entry():
    many = dl.Contact(radius=[1e-3, 2e-3], modulus=1e9)
    assert many == dl.Contact(radius=np.array([1e-3, 2e-3]), modulus=1e9) and many != many.with_values(radius=[1e-3, 3e-3])
    assert many != many.with_values(radius=1e-3) and many != 3
    one = dl.Contact(radius=1e-3, modulus=1e9)
    assert hash(one) == hash(dl.Contact(radius="1mm", modulus=1e9)) and one == dl.Contact(radius="1mm", modulus=1e9)


def test_unlikely_values_warn_at_the_line_of_the_caller():
    with pytest.warns(dl.ValidityWarning) as seen:
        dl.Contact(radius=5e-3, modulus=32e9, sigma=[2e-6, 7e-4])
        dl.Contact(radius=8.76, modulus=32e9)
    assert ["sigma = 0.0007 m" in str(one.message) for one in seen] == [True, False]
    assert {one.filename for one in seen} == {__file__}
    with pytest.warns(dl.ValidityWarning, match="hardness = 3.2e.13 Pa is 1e.03 times"):
        dl.Contact(radius=5e-3, modulus=[32e9, 64e9], hardness=32e12)
    with pytest.warns(dl.ValidityWarning):
        boulder = dl.Contact.between(GRANITE, GRANITE, radius1="8.76m", radius2="flat")
    assert boulder.radius == 8.76


def test_a_contact_is_not_changed():
    contact = dl.Contact(radius=1e-3, modulus=1e9)
    with pytest.raises(AttributeError):
        contact.radius = 2e-3
    assert contact.with_values(radius=2e-3).radius == 2e-3
    assert contact.radius == 1e-3


PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "c": 1e-2, "": 1.0, "k": 1e3, "M": 1e6, "G": 1e9}
OTHERS = {"inch": 0.0254, "N/mm²": 1e6, "N/mm2": 1e6, "kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "deg": math.pi / 180}
OTHERS |= {"g/cm³": 1e3, "g/cm3": 1e3, "°": math.pi / 180, "rad": 1.0, "kg/m³": 1.0, "kg/m3": 1.0, "m/N": 1.0}
OTHERS |= {"mm/N": 1e-3, "um/N": 1e-6, "nm/N": 1e-9, "mm/kN": 1e-6, "um/kN": 1e-9, "m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6}
OTHERS |= {"N/m": 1.0, "N/mm": 1e3, "N/um": 1e6, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6, "1/m": 1.0, "1/mm": 1e3, "1/um": 1e6}
OTHERS |= {"1/m²": 1.0, "1/m2": 1.0, "1/mm²": 1e6, "1/mm2": 1e6, "1/um²": 1e12, "1/um2": 1e12, "1/s": 1.0, "/s": 1.0}

OTHERS |= {"in": 0.0254, "micron": 1e-6, "Å": 1e-10, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 0.45359237 * 9.80665}

OTHERS |= {"N/m": 1.0, "N/mm": 1e3, "N/um": 1e6, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6, "1/m": 1.0, "1/mm": 1e3, "1/um": 1e6}
OTHERS |= {"1/m²": 1.0, "1/m2": 1.0, "1/mm²": 1e6, "1/mm2": 1e6, "1/um²": 1e12, "1/um2": 1e12, "1/s": 1.0, "/s": 1.0}


@pytest.mark.parametrize("unit", UNITS)
def test_every_spelling_of_a_unit(unit):
    """Text with each spelling is the number in the SI unit."""
    for symbol, factor in UNITS[unit].items():
        expected = OTHERS[symbol] if symbol in OTHERS else PREFIXES[symbol.removesuffix(unit)]
        assert factor == pytest.approx(expected, rel=1e-15)
        assert quantity(f"2.5 {symbol}", "x", unit) == pytest.approx(2.5 * expected, rel=1e-15)


def test_the_softer_body_decides_in_every_way_to_a_contact():
    """It is its surface's hardness, else its material's. Before, a grain without one on its surface counted for nothing."""
    hard, soft = dl.Material(60e9, 0.25, hardness=4e9), dl.Material(60e9, 0.25, hardness=1e9)
    measured, plain = dl.Surface(1e-6, 2.2, hardness=5e9), dl.Surface(1e-6, 2.2)
    scene = dl.Scene(radii=5e-3, materials=[hard, soft], surfaces=[measured, plain], force=(1.0, 10.0))
    first, second = Grain(5e-3, hard, measured), Grain(5e-3, soft, plain)
    bodies = [replace(hard, surface=measured), replace(soft, surface=plain)]
    between = dl.Contact.between(*bodies, radius1=5e-3, radius2=5e-3)
    assert between.hardness == first.contact(second).hardness == scene.contacts(2.5e-3)[1].hardness == 1e9
    assert first.contact(first).hardness == scene.contacts(2.5e-3)[0].hardness == 5e9


def test_sigma_by_its_former_name():
    """`roughness` was Sq of one surface in commands and σ of the pair here: √2 apart, without a word."""
    said = r"^the roughness of a contact is σ = √\(Sq1² \+ Sq2²\) of the pair, not Sq of one surface: write sigma"
    new = dl.Contact(4e-3, 32e9, sigma=2e-6)
    with pytest.warns(FutureWarning, match=said) as seen:
        assert dl.Contact(4e-3, 32e9, roughness="2um") == new
        assert new.with_values(roughness=3e-6) == new.with_values(sigma=3e-6)
        assert new.roughness == 2e-6
    assert len(seen) == 3 and {one.filename for one in seen} == {__file__}
    for twice in (lambda: dl.Contact(4e-3, 32e9, 2e-6, roughness=2e-6), lambda: new.with_values(sigma=1e-6, roughness=1e-6)):
        with pytest.raises(dl.DemlawsError, match="are the same quantity of a contact: give sigma"):
            twice()
    assert "roughness" not in repr(new) and [field.name for field in fields(new)][2] == "sigma"
