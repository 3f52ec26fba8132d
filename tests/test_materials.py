"""Typical values: records with sources, contacts made of them, and unknown quantities."""

import pytest

import demlaws as dl
from demlaws.contact import GRANITE
from demlaws.materials import SYMBOLS, names, typical
from demlaws.plugins.grains import Grain


@pytest.mark.parametrize("name", names())
def test_record(name):
    values = typical(name)
    assert set(values) == set(SYMBOLS)
    for quantity, value in values.items():
        assert value.source, quantity
        if value.low is not None:
            assert value.low <= value.high
            assert value.value is None or value.low <= value.value <= value.high
    material = getattr(dl.materials, name)
    assert isinstance(material, dl.Material) and material.young == values["young"].value
    assert (material.surface is None) == (values["roughness"].value is None)


def test_granite_is_that_of_the_tests():
    granite = dl.materials.granite
    assert (granite.young, granite.poisson, granite.density) == (GRANITE.young, GRANITE.poisson, GRANITE.density)
    assert granite.hardness == pytest.approx(GRANITE.hardness, rel=1e-4)


def test_contact_takes_the_usual_surfaces():
    glass, granite = dl.materials.glass, dl.materials.granite
    pair = dl.Contact.between(glass, granite, radius1="2mm", radius2="3mm")
    joined = glass.surface.combined(granite.surface)
    assert (pair.sigma, pair.fractal_dimension) == (joined.roughness, 2.22)
    assert pair.hardness == glass.hardness < granite.hardness
    measured = dl.Contact.between(
        glass, granite, radius1="2mm", radius2="flat", roughness1="1um", roughness2=0, fractal_dimension=2.4
    )
    assert (measured.sigma, measured.fractal_dimension) == (1e-6, 2.4)


def test_grain_scene_and_softening_take_them_too():
    granite = dl.materials.granite
    assert Grain(4e-3, granite).surface == granite.surface
    assert Grain(4e-3, dl.Material(1e9, 0.2)).surface == dl.Surface()
    scene = dl.Scene(radii=4e-3, materials=granite, force=(1, 10))
    assert scene.surfaces == (granite.surface,)
    softer = dl.soften(granite, 8.0)
    assert softer.young == granite.young / 8 and softer.surface.roughness == pytest.approx(4 * granite.surface.roughness)


@pytest.mark.parametrize(
    "use",
    [
        lambda rock: dl.Contact.between(rock, dl.materials.steel, radius1=1e-3, radius2="flat"),
        lambda rock: dl.Contact.between(dl.materials.steel, rock, radius1=1e-3, radius2="flat", roughness1=0),
        lambda rock: Grain(4e-3, rock).contact(Grain(4e-3, dl.materials.steel)),
        lambda rock: dl.Scene(radii=4e-3, materials=rock, force=(1, 10)).contacts(2e-3)[0],
    ],
)
def test_unknown_roughness_is_never_smooth(use):
    """A law of smooth contacts takes the contact; one that needs the roughness names it, and how it is given."""
    contact = use(dl.materials.basalt)
    assert contact.sigma is None and dl.law("hertz", contact).force(1e-6) > 0.0
    with pytest.raises(dl.DemlawsError, match=r"needs the contact's sigma, .* \(--roughness\), 0 for smooth surfaces"):
        dl.law("rms", contact)


def test_unknown_roughness_may_be_given():
    pair = dl.Contact.between(
        dl.materials.basalt, dl.materials.basalt, radius1=1e-3, radius2="flat", roughness1=0, roughness2=2e-6
    )
    assert pair.sigma == 2e-6


def test_a_surface_is_a_surface():
    with pytest.raises(dl.DemlawsError, match="surface must be a"):
        dl.Material(1e9, 0.2, surface=2e-6)


def test_unknown_names():
    with pytest.raises(AttributeError, match="limestone"):
        dl.materials.marble  # noqa: B018
    with pytest.raises(dl.DemlawsError, match="glass"):
        typical("glas")
    assert set(names()) <= set(dir(dl.materials))
