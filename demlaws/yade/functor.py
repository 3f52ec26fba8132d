"""The functor that a YADE script uses: `Law2_ScGeom_MindlinPhys_Demlaws`."""

import builtins
import keyword
import math

import yade

from demlaws.contact import compliance
from demlaws.core.shear import DEFAULT
from demlaws.errors import DemlawsError, page, warn
from demlaws.laws import HERTZ
from demlaws.yade import material_options, native, selftest
from demlaws.yade.binding import Binding
from demlaws.yade.friction import OF_MATERIALS
from demlaws.yade.pairs import Pairs

NATIVE_ATTRIBUTES = frozenset(yade.Law2_ScGeom_MindlinPhys_Mindlin().dict()) | {"preventGranularRatcheting"}
O = yade.O  # noqa: E741  YADE's name


class Law2_ScGeom_MindlinPhys_Demlaws(yade.Law2_ScGeom_MindlinPhys_Mindlin):
    """A demlaws law as a YADE Law2 functor, in place of Law2_ScGeom_MindlinPhys_Mindlin.

    law: a law's name (`demlaws.laws()`), a `Law`, a `Table`, the path of a saved table, or a dict (label, label) → one of them,
        or a law's name with its options: {("sand", "sand"): ("conical-damage", {"strength": 1e9, "angle": 1.2})}. Without
        them "conical-damage" takes strength and angle from sigmaMax and alpha of the scene's FrictMatCDM, of two of them the
        smaller ones, as native contacts do.
    unloading: a rule's name, or a `Law` or `Table` whose curve the contacts unload along; default: that of the law.
    surfaces: one `demlaws.Surface` for all materials, or a dict label of a YADE material → Surface ("*": every other material).
        A material without a surface is smooth, and a pair of smooth surfaces is Hertz; a Surface needs its roughness, 0 or
        more, where the law uses it. Of two surfaces σ² = Sq1² + Sq2².
    smooth: True allows materials without a surface; by default their first contact is an error if a given label has no
        material, or if there are no surfaces and the law is not Hertz.
    flats: "plane" gives a sphere on a facet, wall or box its own radius as R, which is Hertz's; "yade" keeps YADE's, half of it
        (wall, box) or two thirds (facet).
    radius: R of a level set, a polyhedron and every other shape that is neither sphere nor flat: "body" (YADE's: the distance
        from its centre to the contact), "curvature" (of level sets, where the contact begins; `Curvature(largest=…)` bounds
        it on flat faces), or the measured radius of its edges [m]. Default: the `edge_radius` of its Surface, else as
        "body", with a warning.
    shear: "elastic": K_t is a share of the stiffness with which the contact would unload now, and the shear force falls with it
        (passive); "loading": the same of first loading at the present force; "slip": partial slip;
        "native": Mindlin's shear as YADE has it, which can create energy.
    levels: of "elastic" and "loading", 1 to 8: groups of a contact's springs that touched at similar stiffness and have one
        stretch. With 1 the shear force of a contact whose overlap vibrates is lost.
    shear_ratio: K_t/K, above 0 and at most 4/3; default: that of the materials' Poisson's ratios, as Mindlin's law has it.
    friction: a `demlaws.PressureFriction` for all contacts, or a dict from labels of `surfaces`, or pairs of them, to one; of
        two labels the smaller of each parameter. "materials": the c1 and c2 of FrictMatCDM, also by default if a material of
        the scene has them. Other contacts keep the constant friction of their materials.
    label: name of the law in saved files, unique in a scene and constant.

    Further arguments are the law's own options, or attributes of Law2_ScGeom_MindlinPhys_Mindlin (neverErase, calcEnergy,
    preventGranularRatcheting). E*, friction and damping are the contact's, as in YADE. A law acts in one scene at a time.
    """

    def __init__(
        self,
        law=HERTZ,
        unloading=None,
        surfaces=None,
        *,
        smooth=False,
        flats="plane",
        radius=None,
        shear=DEFAULT,
        levels=None,
        shear_ratio=None,
        friction=None,
        label="demlaws",
        **options,
    ):
        attributes = {name: options.pop(name) for name in list(options) if name in NATIVE_ATTRIBUTES}
        if not isinstance(label, str) or not label.isidentifier() or keyword.iskeyword(label):
            raise DemlawsError(f"label must be a Python name, got {label!r}: YADE makes a variable of it")
        if getattr(vars(builtins).get(label), "__module__", "") == "builtins":
            raise DemlawsError(f"label {label!r} would hide what Python has under this name: YADE makes a variable of it")
        super().__init__(label=label, **attributes)
        modulus = _softest_modulus()
        if shear == "native":
            warn(
                f"shear='native' keeps the shear force where contacts become softer, which can create energy ({page('shear')})"
            )
        choices = {"smooth": smooth, "flats": flats, "shear": shear, "levels": levels, "shear_ratio": shear_ratio}
        if friction is None and any(getattr(stone, "c1", 0.0) for stone in O.materials):
            friction = OF_MATERIALS
        choices["friction"] = friction
        of_materials = material_options.values_of(law, options, O.materials)
        if of_materials:
            law, surfaces = material_options.by_pair(law, options, of_materials, surfaces)
        pairs = Pairs(law, surfaces, unloading, options, modulus, radius=radius, **choices)
        pairs.of_materials = of_materials
        try:
            self.binding = Binding(label, pairs)
            self.binding.check_functor(self)
            selftest.run(self.binding)
        except native.BridgeUnavailable as error:
            from demlaws.yade.reports import unavailable_text

            raise DemlawsError(unavailable_text(error, pairs)) from None
        self.binding.attachment.patch(self)

    @classmethod
    def _remade(cls, label, pairs, attributes):
        """The functor of a law that `saving.pairs_text` describes, in no scene."""
        from demlaws.yade.saving import pairs_from

        functor = cls.__new__(cls)
        yade.Law2_ScGeom_MindlinPhys_Mindlin.__init__(functor, label=label, **attributes)
        functor.binding = Binding(label, pairs_from(pairs))
        functor.binding.attachment.patch(functor)
        return functor

    def __reduce__(self):
        """Copies and pickles: YADE's own would make a functor without arguments, which is Hertz's law."""
        from demlaws.yade.saving import pairs_text

        return type(self)._remade, (self.label, pairs_text(self.binding.pairs), self.settings())

    def __repr__(self):
        from demlaws.yade.reports import describe

        return f"<{type(self).__name__} {self.label!r}: {describe(self.binding)}>"

    __str__ = __repr__

    def totals(self):
        """`Totals` of the current scene: stored energy and plastic dissipation [J], ended contacts included."""
        return self.binding.totals()

    def contacts(self, interactions=None, *, strength=None):
        """All real contacts, or the given ones: a table (`demlaws.responses.contacts`) that `save` writes for ParaView.

        strength: a mean pressure [Pa], or text with a unit; column `above` has which contacts exceed it.
        """
        return self.binding.contacts(interactions, strength)

    def normElastEnergy(self):
        """Stored normal energy [J]; replaces Mindlin's formula, which holds for Hertz only."""
        return self.totals().stored

    @property
    def shearEnergy(self):
        """Stored energy of shear [J], as in `totals()`; YADE's sum with calcEnergy would be Mindlin's."""
        return self.totals().shear_stored

    @property
    def frictionDissipation(self):
        """Energy of shear [J] dissipated by friction and by the opening of contacts, as in `totals()`."""
        return self.totals().shear_dissipated

    def ratioYieldingContacts(self):
        """Share of the real contacts that crush in this step, as in HertzMindlinCDM: of MindlinPhysCDM with rule `thornton`."""
        yielding = [getattr(contact.phys, "isYielding", False) for contact in O.interactions if contact.isReal]
        return sum(yielding) / len(yielding) if yielding else math.nan

    def attributes(self):
        """Attributes of the native functor that are saved with a scene: settings, and YADE's own sums of energy."""
        return {name: value for name, value in self.dict().items() if name != "label" and isinstance(value, bool | int | float)}

    def settings(self):
        """Attributes that change how the functor acts."""
        return {name: value for name, value in self.attributes().items() if isinstance(value, bool)}


def _softest_modulus():
    """E* [Pa] of two bodies of the scene's softest material; None without materials. A marker's, 0, does not count."""
    materials = [m for m in O.materials if isinstance(m, yade.FrictMat) and 0.0 < m.young < math.inf]
    return min((0.5 / compliance(m) for m in materials if compliance(m) > 0.0), default=None)
