"""Inputs of LIGGGHTS and LAMMPS with their contact model replaced by demlaws/table.

Changed are pair_style, pair_coeff and wall lines that have their models in words. Every other line that has, or includes, stock
models of grains stays as it is and is named with its number and what to write by hand.
"""

import os
import re
from pathlib import Path
from typing import NamedTuple

from demlaws.errors import DemlawsError
from demlaws.files import read_text, write_atomically


class Note(NamedTuple):
    """What was done with a line, or could not be."""

    line: int
    text: str
    served: bool = True


class Converted(NamedTuple):
    """Text of the input with demlaws/table, and notes on its lines."""

    text: str
    notes: list
    changed: bool

    @property
    def complete(self):
        """Whether no granular line remains as it was."""
        return all(note.served for note in self.notes)

    def report(self, name):
        """Lines for the user."""
        lines = [f"{name}, line {note.line}: {'' if note.served else 'NOT CONVERTED: '}{note.text}" for note in self.notes]
        if not self.complete:
            lines.append("lines that are not converted keep the engine's model or stop the run: change them first")
        return lines


class _Left(Exception):
    """A granular line that stays as it is: the reason and the remedy."""


_WHOLE_LINE = re.compile(r"(?:.*&[ \t]*\n)*.*\n?")
"""A line, with those that follow one that ends in &."""
_CODE = re.compile(r"""(?:"[^"]*"|'[^']*'|[^#"'])*""")
"""What stands before a comment: a # in quotes begins none."""
_ELSEWHERE = {
    "liggghts": re.compile(r"\bpair_style\b|\bfix\b.*\bwall/gran|\bmodel\s+(hertz|hooke)\b"),
    "lammps": re.compile(r"\bpair_(style|coeff)\b|\bfix\b.*\bwall/gran|\bhertz/material\b"),
}
"""Granular models in other commands, such as `if`, and in other files."""
_BY_HAND = "write the words of the model here"
_MODULI = (
    "Young's moduli stay; the table is for E* = E/(2(1 - nu²)) = {:.4g} Pa: at another modulus roughness changes a contact by "
    "another share; give the modulus of the grains, or a table for softened grains (`demlaws soften`)"
)


def convert(text, engine, table, folder=None, name="", modulus=None):
    """The input `text` of an engine ("liggghts" or "lammps") with the law of `table`, the file's name as the input has it.

    folder: where the files that the input includes are; name: of the input; modulus: E* of the table [Pa].
    """
    if re.search(r"\s", str(table)):
        raise DemlawsError(f"table {str(table)!r}: engines do not accept names with spaces; rename the file")
    text = text.replace("\r\n", "\n")
    lines, notes, changed = [], [], False
    for whole in _WHOLE_LINE.finditer(text):
        line, number = whole[0], text.count("\n", 0, whole.start()) + 1
        code = _CODE.match(line)[0]
        words = re.sub(r"&[ \t]*\n", " ", code).split()
        try:
            new, remarks = _command(engine, words, str(table), folder, name)
        except _Left as left:
            new, remarks = words, []
            notes.append(Note(number, str(left), False))
        if new != words:
            remarks += [_MODULI.format(modulus)] if modulus and not changed else []
            comment = line[len(code) :].strip()
            line, changed = " ".join([*new, comment]).rstrip() + "\n", True
        notes += [Note(number, remark) for remark in remarks]
        lines.append(line)
    if not notes:
        raise DemlawsError(
            f"no pair_style, pair_coeff or wall line with a granular model of {engine.upper()} in this input: nothing to "
            "convert (lines with demlaws/table get another table by hand)"
        )
    return Converted("".join(lines), notes, changed)


def convert_file(path, engine, table, *, out=None):
    """Convert the input `path` and write it as `out` (default: beside it, with .demlaws at its end); (out, `Converted`).

    `table` is a path from here; in the input it stands as seen from the folder of `out`, where the engine runs. If no line
    can be converted, no file is written, and `out` is None.
    """
    from demlaws.curves.table_grammar import parse

    path, table = Path(path), Path(table)
    out = path.with_name(path.name + ".demlaws") if out is None else Path(out)
    if not table.is_file():
        raise DemlawsError(f"table {table} does not exist; `demlaws table` writes one")
    modulus = parse(table.read_bytes(), table).values["contact"].modulus
    conversion = convert(read_text(path), engine, os.path.relpath(table, out.parent), path.parent, path.name, modulus)
    if not conversion.changed:
        return None, conversion
    write_atomically(out, conversion.text)
    return out, conversion


def _command(engine, words, table, folder, name):
    """(words of the converted command, remarks); the same words where it has no stock model. Raises _Left."""
    first, other = [*words, "", ""][:2]
    if first in ("pair_style", "pair_coeff", "fix"):
        return _liggghts(words, table) if engine == "liggghts" else _lammps(words, table)
    if first in ("include", "jump") and other not in ("SELF", name):
        file = Path(folder or "", other)
        if folder is None or not file.is_file() or _ELSEWHERE[engine].search(read_text(file)):
            raise _Left(f"{first} {other}: if that file has granular lines, convert it, too, and write its new name here")
    elif first == "read_restart" and engine == "lammps":
        return words, [
            f"{first} {other}: unless this file is of a run with demlaws/table, its pairs keep the models and histories that "
            "are in it: start from positions (write_data in the run before, read_data and pair_coeff lines here)"
        ]
    elif "$" in first:
        raise _Left(f"{first}: a command by variable; write it here if it is a granular one")
    elif first != "print" and (model := _ELSEWHERE[engine].search(" ".join(words))):
        raise _Left(f"{first} ... {model[0]}: convert does not read this command; change it yourself")
    return words, []


# --- LIGGGHTS

_SUB_MODELS = {
    "tangential": ("off", "no_history", "history", "demlaws"),
    "rolling_friction": ("off", "cdt", "epsd", "epsd2"),
    "cohesion": ("off",),
    "surface": ("default",),
}
_STOCK_SETTINGS = (
    "absolute_damping",
    "viscous",
    "computeElasticPotential",
    "heating_normal_hertz",
    "heating_tangential_history",
)
"""Settings (with a value) of stock models that demlaws/table has no use for."""


def _liggghts(words, table):
    style = words[3] if words[0] == "fix" and len(words) > 3 else " ".join(words[1:])
    if words[0] == "pair_style" and "gran" in words[1:]:
        start, own, source = words.index("gran") + 1, ["table", table], f"with {table}"  # of hybrid styles gran is the last
    elif style == "wall/gran":
        start, own, source = 4, [], "with the table of the pair style"
    elif style.startswith("wall/gran") or (words[0] == "pair_style" and re.search(r"\bgran|\$", style)):
        raise _Left(f"{' '.join(words[:4])}: not a style of LIGGGHTS 3 in words; write `gran model hertz tangential history`")
    else:
        return words, []
    head, normal = [*words[start:], "", ""][:2]
    if head != "model" or "$" in normal:
        raise _Left(f"{' '.join(words[: start + 2])}: {_BY_HAND}: `model hertz tangential history`")
    if normal == "demlaws/table":
        return words, []
    out, remarks, at = [*words[:start], "model", "demlaws/table"], [], start + 2
    while at < len(words) and words[at] not in ("primitive", "mesh"):  # behind these come places and sizes
        word, value = [*words[at:], ""][:2]
        if "$" in word or ("$" in value and word in _SUB_MODELS):
            raise _Left(f"{word} {value}: {_BY_HAND}")
        if value not in _SUB_MODELS.get(word, [value]):
            raise _Left(f"{word} {value}: demlaws/table does not run with it; choose one of {', '.join(_SUB_MODELS[word])}")
        if word in _STOCK_SETTINGS:
            remarks.append(f"{word} {value} is an option of {normal} and was deleted")
        elif (word, value) == ("tangential", "history"):
            remarks.append("tangential history is now tangential demlaws, which creates no energy")
            out += ["tangential", "demlaws"]
        else:
            out += words[at : at + 2]
        at += 2
    return [*out, *words[at:], *own], [*remarks, f"model {normal} is now demlaws/table, {source}"]


# --- LAMMPS

_MATERIAL = "hertz/material"


def _lammps(words, table):
    at = _normal_of(words)
    normal = words[at] if at < len(words) else ""
    if "$" in normal or normal in ("hertz", "hooke", "jkr", "dmt", "mdr"):
        raise _Left(f"{' '.join(words[: at + 1])}: write {_MATERIAL} E eta nu here first")
    if normal != _MATERIAL:
        return words, []
    rest, remarks = words[at + 1 :], [f"{_MATERIAL} is now demlaws/table with {table}"]
    shear = rest.index("tangential") + 1 if "tangential" in rest else len(rest)
    model = " ".join(rest[shear : shear + 1])
    if model.startswith("mindlin") and rest[shear + 1 : shear + 2] == ["NULL"]:
        remarks.append(f"tangential {model} NULL is now tangential demlaws, which creates no energy")
        rest[shear : shear + 2] = ["demlaws"]
    elif model:
        remarks.append(f"tangential {model} stays")
    damping = rest[rest.index("damping") + 1] if "damping" in rest[:-1] else "viscoelastic"
    if damping not in ("none", "demlaws/tangent"):
        remarks.append(
            f"damping {damping} stays: it does not take the tangent stiffness of the law, on which the rebound depends; "
            "damping demlaws/tangent does, with eta as the coefficient of restitution"
        )
    return [*words[:at], "demlaws/table", table, *rest], remarks


def _normal_of(words):
    """Place of the normal model in the words of a command; their number if it has none. Raises _Left for an old style."""
    style = " ".join(words[3:5] if words[0] == "fix" else words[1:])
    if words[0] == "pair_coeff" and words[3:4] == ["granular"]:  # hybrid styles name it, and its number where there are several
        return 5 if words[4:5] and words[4].isdigit() else 4
    if words[0] == "pair_coeff":
        return 3
    if re.match(r"wall/gran(/region)? granular$", style):
        return 5
    if style.startswith("wall/gran") or (words[0] == "pair_style" and re.search(r"\bgran(ular)?/|\$", style)):
        raise _Left(
            f"{words[0]} ... {style}: an old style, or one by variable; write `granular` and {_MATERIAL} E eta nu first"
        )
    return len(words)
