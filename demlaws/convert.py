"""Inputs of LIGGGHTS and LAMMPS with their contact model replaced by demlaws/table.

Changed are the pair_style, pair_coeff and wall lines; words that the plugins do not know stay where they are and are listed,
so that the plugin refuses them by name: no model is dropped silently.
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

    def report(self, name):
        """Lines for the user."""
        lines = [f"{name}, line {note.line}: {'' if note.served else 'NOT SERVED: '}{note.text}" for note in self.notes]
        if not all(note.served for note in self.notes):
            lines.append("what is not served was left as it is: the run stops there until you change it")
        return lines


def convert(text, engine, table):
    """The input `text` of an engine ("liggghts" or "lammps") with the law of `table`, the file's name as the input has it."""
    if re.search(r"\s", str(table)):
        raise DemlawsError(f"table {str(table)!r}: engines do not accept names with spaces; rename the file")
    change, lines, notes = {"liggghts": _liggghts, "lammps": _lammps}[engine], [], []
    commands = set()
    for number, line in _whole_lines(text):
        code, mark, comment = line.partition("#")
        words = re.sub(r"&[ \t]*\n", " ", code).split()
        texts = []
        commands.update(words[:1])
        if words[:1] == ["units"] and words[1:2] and words[1] not in _UNITS[engine]:
            texts.append((f"units {words[1]}: tables are in SI; write the input in units {' or '.join(_UNITS[engine])}", False))
        new = change(words, str(table), lambda text, served=True, into=texts: into.append((text, served)))
        notes += [Note(number, *entry) for entry in texts]
        lines.append(line if new is None else " ".join(new) + (f" {mark}{comment}" if mark else ""))
    if engine == "lammps" and not commands & {"units", "include", "read_restart"}:
        notes.insert(0, Note(1, "no units line, so that LAMMPS takes units lj: write the input in units si", False))
    if not any(note.served for note in notes):
        raise DemlawsError(f"no pair_style or wall/gran line of {engine}'s granular models in this input: nothing to convert")
    return Converted("\n".join(lines) + "\n", notes)


def convert_file(path, engine, table, out=None):
    """Convert the input `path` and write it as `out` (default: beside it, with .demlaws at its end); (out, `Converted`).

    `table` is a path from here; in the input it stands as seen from the folder of `out`, where the engine runs.
    """
    path, table = Path(path), Path(table)
    out = path.with_name(path.name + ".demlaws") if out is None else Path(out)
    if not table.is_file():
        raise DemlawsError(f"table {table} does not exist; `demlaws table` writes one")
    conversion = convert(read_text(path), engine, os.path.relpath(table, out.parent))
    write_atomically(out, conversion.text)
    return out, conversion


_UNITS = {"liggghts": ("si", "cgs", "micro", "nano"), "lammps": ("si",)}


def _whole_lines(text):
    """(number of its first line, line) with lines that end in & joined to the next."""
    lines = text.replace("\r\n", "\n").split("\n")
    at = 0
    while at < len(lines):
        first, line = at, lines[at]
        while re.search(r"&[ \t]*$", line) and at + 1 < len(lines):
            at += 1
            line += "\n" + lines[at]
        at += 1
        if at < len(lines) or line:
            yield first + 1, line


# --- LIGGGHTS

_SUB_MODELS = {
    "tangential": ("off", "no_history", "history", "demlaws"),
    "rolling_friction": ("off", "cdt", "epsd", "epsd2"),
    "cohesion": ("off", "sjkr", "sjkr2"),
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


def _liggghts(words, table, note):
    if words[:2] == ["pair_style", "gran"]:
        start, tail = 2, ["table", table]
    elif words[:1] == ["fix"] and words[3:4] and words[3].startswith("wall/gran"):
        start, tail = 4, []
    else:
        if words[:1] == ["include"]:
            note(f"{words[1]} is another file: convert it, too, if it has pair_style or wall lines")
        if words[:2] == ["pair_style", "hybrid"] or any(word.startswith(("gran/hertz", "gran/hooke")) for word in words):
            note(f"{' '.join(words[:3])} ...: an old or hybrid style; write `pair_style gran model hertz` first", False)
        for word in ("superquadric", "convexhull", "coarsegraining"):
            if words and (word in words[0] or any(part.startswith(word) for part in words[1:])):
                note(f"{word}: demlaws/table serves spheres without coarse graining", False)
        return None
    if words[start : start + 1] != ["model"]:
        note("no word 'model': an old style; write `model hertz tangential history` first", False)
        return None
    if words[start + 1] == "demlaws/table":
        return None
    out, normal, at = [*words[:start], "model", "demlaws/table"], words[start + 1], start + 2
    while at < len(words):
        word, value = words[at], words[at + 1] if at + 1 < len(words) else ""
        if word in _SUB_MODELS:
            if (word, value) == ("tangential", "history"):
                value = "demlaws"
                note("tangential history is now tangential demlaws, which creates no energy")
            elif value not in _SUB_MODELS[word]:
                note(f"{word} {value}: choose one of {', '.join(_SUB_MODELS[word])}", False)
            out += [word, value]
            at += 2
        elif word in _STOCK_SETTINGS:
            note(f"{word} {value} belongs to {normal} and was left out")
            at += 2
        else:
            out.append(word)
            at += 1
    note(f"model {normal} is now demlaws/table" + (f" with {table}" if tail else ", with the table of the pair style"))
    return out + tail


# --- LAMMPS

_MATERIAL = "hertz/material"


def _lammps(words, table, note):
    if words[:1] == ["pair_coeff"] and len(words) > 3:
        at = 3
    elif words[:1] == ["fix"] and words[3:4] and words[3].startswith("wall/gran") and "granular" in words:
        at = words.index("granular") + 1
    else:
        if words[:1] == ["include"]:
            note(f"{words[1]} is another file: convert it, too, if it has pair_coeff or wall lines")
        if words[:1] in (["pair_style"], ["fix"]) and any(re.match(r"gran/h|hertz/history|hooke", word) for word in words):
            note(f"{' '.join(words)}: an old style; write it as granular with {_MATERIAL} E eta nu first", False)
        return None
    normal = words[at] if at < len(words) else ""
    if normal.startswith("demlaws/table") or not re.match(r"hertz|hooke|jkr|dmt|mdr", normal):
        return None
    if normal != _MATERIAL:
        what = "cohesion is not served" if normal in ("jkr", "dmt") else "it does not name Young's modulus and Poisson's ratio"
        note(f"{normal}: {what}; write {_MATERIAL} E eta nu first", False)
        return None
    note(f"{_MATERIAL} is now demlaws/table with {table}")
    rest = words[at + 1 :]
    shear = rest.index("tangential") + 1 if "tangential" in rest else len(rest)
    if rest[shear : shear + 1] and rest[shear].startswith("mindlin") and rest[shear + 1 : shear + 2] == ["NULL"]:
        note(f"tangential {rest[shear]} NULL is now tangential demlaws, which creates no energy")
        rest[shear : shear + 2] = ["demlaws"]
    return [*words[:at], "demlaws/table", table, *rest]
