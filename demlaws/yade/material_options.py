"""Options of a law that materials of the scene have, as FrictMatCDM has those of the Conical Damage Model."""

from demlaws.contact import Surface
from demlaws.laws.registry import find, laws


def values_of(law, options, materials):
    """Label → {attribute: value} of the materials with the attributes of a law's options that are not given.

    A material without a label gets one, by which contacts find its law. {}: no such option, or no such material.
    """
    if not isinstance(law, str) or law not in laws():
        return {}
    names = [one.of_material for name, one in find(law).options.items() if one.of_material and options.get(name) is None]
    found = {}
    for n, material in enumerate(materials):
        if names and all(hasattr(material, name) for name in names):
            material.label = material.label or f"{type(material).__name__} {n}"
            found[material.label] = {name: float(getattr(material, name)) for name in names}
    return found


def by_pair(law, options, values, surfaces):
    """Law of each two labels, and surfaces that have these labels. A material without the attributes takes the other one's."""
    if isinstance(surfaces, dict | None):
        surfaces = dict.fromkeys(values, Surface(0.0)) | (surfaces or {})
    of_attribute = {one.of_material: name for name, one in find(law).options.items() if one.of_material}
    pairs = {}
    for label, own in values.items():
        for other in sorted({"", *values, *(surfaces if isinstance(surfaces, dict) else ())} - {"*"}):
            theirs = values.get(other, own)
            smaller = {of_attribute[name]: min(value, theirs[name]) for name, value in own.items()}
            pairs[tuple(sorted((label, other)))] = law, options | smaller
    return pairs, surfaces


def difference(values, material):
    """Text on an attribute of a material that is not as `values_of` has found it; None: all are."""
    for name in next(iter(values.values()), ()):
        now, taken = getattr(material, name, None), values.get(material.label, {}).get(name)
        if now is not None and now != taken:
            then = "did not exist" if taken is None else f"had {taken:g}"
            return (
                f"material {material.label!r} has {name} = {now:g}, and {then} when the law was made, which took it from the "
                "materials then: set it before, or give the law its options"
            )
    return None
