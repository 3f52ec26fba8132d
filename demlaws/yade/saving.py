"""What a saved scene has of a law: its description and the history of its contacts, as text. Loaded when a scene is saved or
loaded, or given another law."""

import base64
import json
import tempfile
import zlib
from pathlib import Path

import numpy as np

from demlaws.core.unloading import GIVEN
from demlaws.errors import DemlawsError
from demlaws.law import Table
from demlaws.laws.registry import home_of, laws
from demlaws.yade.friction import choice_from
from demlaws.yade.omega import real_contacts
from demlaws.yade.pairs import ALL_LABELS, TYPICAL_MODULUS, LawSource, Pairs
from demlaws.yade.radii import Curvature

FORMER_VERSION = (
    "the scene was saved by a former version of demlaws, whose contacts have another history: continue it with that "
    "version, or take its bodies into a new scene"
)


def law_text(functor):
    """JSON of a law at work in the current scene, with the history of its contacts."""
    binding = functor.binding
    bodies, rows = binding.attachment.saved(real_contacts())
    history = zlib.compress(bodies.tobytes() + rows.tobytes())
    content = {"account": binding.account, "seen": binding.seen, "bound": binding.bound, "attributes": functor.attributes()}
    content |= {"contacts": len(rows), "history": base64.b64encode(history).decode()}
    text = json.dumps(content | {"pairs": pairs_text(binding.pairs)})
    return f"{zlib.crc32(text.encode()):08x} {text}"


def content_of(text, label):
    """Content of the `law_text` that a loaded scene has of the law of this label."""
    digest, _, content = text.partition(" ")
    if text.startswith("{"):
        raise DemlawsError(FORMER_VERSION)
    if digest != f"{zlib.crc32(content.encode()):08x}":
        raise DemlawsError(
            f"the saved scene is damaged: its record of law {label!r}, which has the history of the contacts, is not as "
            "demlaws wrote it. Load another copy, or save the scene again; O.load takes no part of a damaged one"
        )
    return json.loads(content)


def restore(binding, content):
    """Give the contacts of the current scene, which was loaded, the history in the content of `law_text`."""
    if "history" not in content:
        raise DemlawsError(FORMER_VERSION)
    count, history = content["contacts"], zlib.decompress(base64.b64decode(content["history"]))
    bodies = np.frombuffer(history, np.int64, 2 * count).reshape(count, 2)
    dtype = binding.attachment.saved_dtype
    if len(history) != bodies.nbytes + count * dtype.itemsize:
        raise DemlawsError(FORMER_VERSION)
    binding.attachment.restore(bodies, np.frombuffer(history, dtype, count, bodies.nbytes), real_contacts())


def same_law(one, other):
    """Whether two bindings are the same law: contacts of one may continue with the other."""
    return pairs_text(one.pairs, True) == pairs_text(other.pairs, True)


# --- laws between surfaces


def pairs_text(pairs, identity=False):
    """JSON from which `pairs_from` makes the same pairs in another process; identity: what makes two laws the same."""
    content = {
        "unloading": pairs.unloading,
        "modulus": pairs.modulus,
        "surfaces": {label: vars(surface) for label, surface in pairs.all_surfaces().items()},
        "default": pairs.default and _source_content(pairs.default),
        "special": [[*pair, _source_content(source)] for pair, source in pairs.by_pair.items()],
        "smooth": pairs.smooth,
        "flats": pairs.flats,
        "shear": pairs.shear_name,
        "levels": pairs.levels,
        "shear_ratio": pairs.shear_ratio,
        "radius": pairs.radii.choice,
        "friction": pairs.friction.content(),
        "of_materials": pairs.of_materials,
    }
    if user_laws(pairs):
        content["answers"] = _sample_forces(pairs)
    if identity:
        del content["modulus"], content["smooth"], content["of_materials"]
    try:
        return json.dumps(content, default=lambda value: value.portable())
    except (TypeError, AttributeError) as error:
        raise DemlawsError(f"the law's options cannot be saved with the simulation: {error}") from None


def pairs_from(text):
    """Pairs from the text of a saved scene."""
    content = json.loads(text)
    if "levels" not in content:
        raise DemlawsError(FORMER_VERSION)
    law = {(a, b): _source_from(one) for a, b, one in content["special"]}
    if content["default"]:
        law = _source_from(content["default"])
    options = {name: content[name] for name in ("smooth", "flats", "shear", "shear_ratio")}
    options["friction"] = choice_from(content.get("friction"), ALL_LABELS)
    options["levels"], radius = content["levels"] or None, content["radius"]
    options["radius"] = Curvature(*radius) if isinstance(radius, list) else radius
    pairs = Pairs(law, content["surfaces"], content["unloading"], {}, content.get("modulus"), **options)
    pairs.of_materials = content.get("of_materials", {})
    answers = content.get("answers")
    if answers is not None and not np.allclose(answers, _sample_forces(pairs), rtol=1e-8, atol=0.0, equal_nan=True):
        raise DemlawsError(
            f"law {', '.join(map(repr, user_laws(pairs)))} is registered, but gives other forces than when the scene was "
            "saved: the history of the contacts belongs to the former law. Register the law unchanged"
        )
    return pairs


def user_laws(pairs):
    """Names of the laws of this scene that are not the package's: their functions may differ under one name."""
    names = {definition.name for source in pairs.sources for definition in source.definitions()}
    return sorted(name for name in names if home_of(name) != home_of("hertz"))


def _sample_forces(pairs):
    """Forces [N] that tell laws of one name apart: of every pair on loading, unloading and loading further.

    At one R and E* whatever the bodies are, since more of them may have come when the same law is made again.
    """
    numbers = range(len(pairs.shapes))
    rows = pairs.contacts_of(numbers, [pairs.typical_contact(number)[0] for number in numbers], TYPICAL_MODULUS)
    forces = []
    for depth in (1e-5, 1e-4, 1e-3, 9e-4, 4e-3):
        rows["overlap"] = depth * rows["radius"]
        forces.append([float(f"{force:.9e}") for force in pairs.evaluate(rows)[0]["kno"] * rows["overlap"] ** 1.5])
    return forces


def _source_content(source):
    """Plain content of a `LawSource`."""
    if source.table is None:
        content = {"law": source.name, "options": source.options, "only": source.only}
        return content if source.curve is None else {**content, "curve": _source_content(source.curve), "ratios": source.ratios}
    with tempfile.TemporaryDirectory() as folder:
        text = source.table.save(Path(folder) / "table.txt").read_bytes()
    return {"table": base64.b64encode(zlib.compress(text, 9)).decode()}


def _source_from(content):
    """A `LawSource` from its content."""
    if "table" not in content:
        if content["law"] not in laws():
            raise DemlawsError(
                f"the scene was saved with law {content['law']!r}, which is not registered in this process: register it "
                "as it was (dl.register, dl.load_laws) before O.load"
            )
        source = LawSource(content["law"], content["options"])
        source.only = content.get("only") and tuple(content["only"])
        if "curve" in content:
            source.curve, source.ratios = _source_from(content["curve"]), tuple(content["ratios"])
            source.unloading = GIVEN
        return source
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.txt"
        path.write_bytes(zlib.decompress(base64.b64decode(content["table"])))
        return LawSource(Table.load(path), {})
