"""Inputs of LIGGGHTS and LAMMPS with their contact model replaced by demlaws/table.

Changed are pair_style, pair_coeff and wall lines, also in quoted commands of `if` and `run … every`, and with models from
variables of the input. A granular line that is not converted stays as it is and is named with its line and the reason.
"""

import contextlib
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
    changed: bool = True

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


def convert(text, engine, table, folder=None, name="", modulus=None):
    """The input `text` of an engine ("liggghts" or "lammps") with the law of `table`, the file's name as the input has it.

    folder: where the files that the input includes are; name: of the input; modulus: E* of the table [Pa]. An input that has
    been converted gets `table` in place of its own, if that is one.
    """
    if re.search(r"\s", str(table)):
        raise DemlawsError(f"table {str(table)!r}: engines do not accept names with spaces; rename the file")
    if name.endswith((".py", ".ipynb")) or _PYTHON.search(text):
        raise DemlawsError(
            f"{name or 'this input'} is a Python script, of whose commands only a part would be found: write the commands into "
            "an input file, convert that, and read it with lmp.file(...)"
        )
    job = _Conversion(engine, str(table), folder, {name} if name else set(), modulus)
    converted = job.text(text)
    if engine == "lammps":
        _look_at_restart(job)
    if not job.changed and job.complete() and len(job.tables) == 1:
        job = _Conversion(engine, str(table), folder, {name} if name else set(), modulus, job.tables.pop())
        converted = job.text(text)
    elif not job.changed and len(job.tables) > 1:
        tables = ", ".join(sorted(job.tables))
        raise DemlawsError(f"{name or 'this input'} has several tables, {tables}: write the names of new ones there yourself")
    if not job.found:
        raise DemlawsError(
            f"no pair_style or fix wall/gran line of {engine.upper()}'s granular models in this input: nothing to convert"
        )
    return Converted(converted, job.notes, job.changed)


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


_PYTHON = re.compile(r"(?m)^\s*(from|import) +[\w.]+|\.commands?(_string|_list)?\(")
_LEFT = {"liggghts": re.compile(r"\bmodel\s+(hertz|hooke)\b"), "lammps": re.compile(r"\bhertz/material\b")}
"""Stock models, in commands that are not read here."""
_NO_COMMANDS = {"variable", "print", "label", "shell", "log", "echo"}
_UNITS = {"cgs": 0.1, "micro": 1e3, "nano": 1e6}
"""Units of LIGGGHTS → their unit of a modulus [Pa]."""
_QUOTED = r'"""(.*?)"""|"(.*?)"|\'(.*?)\''
_TOKEN = re.compile(rf"{_QUOTED}|\S+", re.S)
_VARIABLE = re.compile(r"\$(?:\{(\w+)\}|(\w))")


class _Word(str):
    """A word with the values of variables; `raw` is its text in the input, None where it is a part of a value."""

    raw: "str | None"
    __slots__ = ("raw",)


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


def _without_comment(line):
    """The command of a line, and its comment; a # in quotes begins none."""
    blanked = re.sub(_QUOTED, lambda match: " " * len(match[0]), line, flags=re.S)
    at = blanked.find("#")
    return (line, "") if at < 0 else (line[:at], line[at:])


class _Conversion:
    """One pass through an input."""

    def __init__(self, engine, table, folder, files, modulus=None, former=None):
        self.engine, self.table, self.folder, self.files, self.modulus = engine, table, folder, files, modulus
        self.former = former  # table that is replaced by the new one; None: stock models are
        self.told = set()  # notes that are made once
        self.tables = set()  # of lines that have one
        self.restart = None  # (line, file) of LAMMPS's read_restart
        self.coefficients = False  # whether there is a pair_coeff line of granular
        self.change = {"liggghts": _liggghts, "lammps": _lammps}[engine]
        self.values = {}  # of variables: text
        self.numbers = {}  # of variables of style equal: text of a number
        self.pascals = 1.0  # unit of a modulus [Pa]
        self.notes, self.line = [], 0
        self.granular = None  # the pair style; None: not in the input so far
        self.hybrid = False
        self.found = self.changed = False

    def note_once(self, text):
        """Note on the first line that it is true of."""
        if text not in self.told:
            self.told.add(text)
            self.note(text)

    def note(self, text, served=True):
        """Note on the present line."""
        self.notes.append(Note(self.line, text, served))

    def complete(self):
        """Whether nothing is left that has to be converted."""
        return all(note.served for note in self.notes)

    def text(self, text):
        """Converted text of an input."""
        lines = []
        for self.line, line in _whole_lines(text):
            code, comment = _without_comment(line)
            known = len(self.notes)
            new = self.command(re.sub(r"&[ \t]*\n", " ", code))
            left = new is None and len(self.notes) == known and _LEFT[self.engine].search(code)
            if left and code.split()[0] not in _NO_COMMANDS:
                self.leave(f"{code.split()[0]} ... {left[0]}: convert does not read this command; change it yourself")
            lines.append(line if new is None else new + (f" {comment}" if comment else ""))
        return "\n".join(lines) + "\n"

    def command(self, code):
        """Converted command, or None where it stays."""
        words = self._words(code)
        if not words:
            return None
        first, other = words[0], words[1] if len(words) > 1 else ""
        if first == "variable":
            self._define(code)
        elif first == "units":
            self.pascals = _UNITS.get(other, 1.0)
        elif first in ("include", "jump") and other not in ("SELF", *self.files):
            self._other_file(first, other)
        elif "$" in first:
            self.note(f"{first} has no single value in this input: write the command itself if it is a granular one", False)
        elif first in ("pair_style", "pair_coeff", "fix"):
            return self._granular(words)
        elif first == "delete_atoms" and "compress no" not in " ".join(words):
            self.note(
                "delete_atoms renumbers the particles, and contacts lose their history: add `compress no`; otherwise the run "
                "stops here once there are contacts"
            )
        elif first in ("if", "run"):
            return self._quoted(code)
        elif first == "read_restart" and self.engine == "lammps":
            self.restart = (self.line, other)
        return None

    def _granular(self, words):
        """Converted pair_style, pair_coeff or fix command, or None where it stays."""
        if words[0] == "pair_style":
            self.granular = any(word in ("gran", "granular") for word in words[1:])
            self.hybrid = words[1:2] != [] and words[1].startswith("hybrid")
        new = self.change(self, words)
        if new is None:
            return None
        self.found = self.changed = True
        kept = {id(word) for word in new}
        if any(word.raw is None or (word.raw != word and id(word) not in kept) for word in words):
            self.note("variables in this line are replaced by their values: later changes and -var have no effect")
        return " ".join(getattr(word, "raw", None) or word for word in new)

    def _words(self, code):
        """Words of a command with the values of variables."""
        words = []
        for match in _TOKEN.finditer(code):
            token = match[0]
            value = token if token[0] in "\"'" else self._value(token)
            parts = value.split() if value != token else [token]
            for part in parts:
                word = _Word(part)
                word.raw = token if len(parts) == 1 else None
                words.append(word)
        return words

    def _value(self, token, depth=0):
        """A token with the values of its variables, as far as they are known."""
        value = _VARIABLE.sub(lambda match: self.values.get(match[1] or match[2], match[0]), token)
        return value if value == token or depth > 20 else self._value(value, depth + 1)

    def _define(self, code):
        """Values of string variables, and of index variables with one value; that of any other is not known here."""
        tokens = list(_TOKEN.finditer(code))[1:]
        values = [self._value(token[0]) if _unquoted(token) == token[0] else _unquoted(token) for token in tokens[2:]]
        name, style = [*(token[0] for token in tokens[:2]), "", ""][:2]
        if style == "string" or (style == "index" and name not in self.values and len(values) == 1):
            self.values[name] = values[0] if values else ""
        elif style != "index":
            self.values.pop(name, None)
            self.numbers[name] = values[0] if style == "equal" and values else ""

    def number(self, word):
        """A number, or that of a variable of style equal; ValueError for anything else."""
        variable = _VARIABLE.fullmatch(word)
        return float(self.numbers.get(variable[1] or variable[2], "") if variable else word)

    def _quoted(self, code):
        """A command whose quoted parts are commands: `if`, `run … every`."""

        def converted(match):
            inner = next(part for part in match.groups() if part is not None)
            if re.search(r"(^|\s)(el)?if\s*$", code[: match.start()]):  # a condition
                return match[0]
            new, quote = self.command(inner), match[0][: 3 if match[1] is not None else 1]
            return match[0] if new is None else f"{quote}{new}{quote}"

        new = re.sub(_QUOTED, converted, code, flags=re.S)
        return None if new == code else new.strip()

    def _other_file(self, command, name):
        """Follow a file that the input includes; name it if it has granular lines or cannot be read."""
        remedy = "convert that file and write its new name here"
        path = Path(self.folder or "", name)
        self.files.add(str(name))
        if self.folder is None or not path.is_file():
            self.note(f"{command} {name}: the file cannot be read here; if it has granular lines, {remedy}", False)
            return
        before, state, line = self.notes, (self.changed, self.found), self.line
        self.notes = []
        self.text(read_text(path))
        lines, self.notes, self.line = sorted({note.line for note in self.notes}), before, line
        self.changed, self.found = state
        if lines:
            self.leave(f"{command} {name}: {remedy}; its lines {', '.join(map(str, lines))} are granular")

    def leave(self, text):
        """Name a granular line that stays as it is."""
        self.found = True
        self.note(text, False)


def _unquoted(match):
    """Text of a token without its quotes."""
    return next((part for part in match.groups() if part is not None), match[0])


def _unknown(words):
    """The first word with a variable that has no value in the input, or None."""
    return next((word for word in words if "$" in word), None)


SOFTENED = 1.5
"""Factor between the modulus of an input and that of the table from which it is asked about."""


def _ask_about_modulus(job, young, poisson=("0.25",)):
    """Note where Young's modulus of the input is not that of the table: roughness matters less in softened grains."""
    try:
        value = job.pascals * job.number(young[0])
        modulus = 0.5 * value / (1.0 - job.number(poisson[0]) ** 2)
    except (IndexError, ValueError, ZeroDivisionError):
        return
    if job.modulus and modulus > 0.0 and not 1.0 / SOFTENED <= modulus / job.modulus <= SOFTENED:
        job.note_once(
            f"Young's modulus {value:g} Pa has E* = {modulus:.3g} Pa, the table is for {job.modulus:.3g} Pa: at another "
            "modulus roughness changes a contact by another share; give the modulus of the grains, or a table for softened "
            "grains (`demlaws soften`)"
        )


def _other_table(job, words, place):
    """A line that has been converted before, with the new table; None: it stays."""
    if place is None or place >= len(words):
        return None  # a wall of LIGGGHTS, which takes the tables of the pair style
    if "pairtable" in words:
        job.tables |= {words[place], words[words.index("pairtable") + 3]}
        return None
    job.tables.add(words[place])
    job.found = True
    if words[place] != job.former:
        return None
    job.note(f"table {job.former} is now {job.table}")
    return [*words[:place], job.table, *words[place + 1 :]]


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


def _liggghts(job, words):
    if words[0] == "fix" and words[4:5] == ["youngsModulus"]:
        for young in words[6:]:
            _ask_about_modulus(job, [young])
    if words[0] == "pair_style" and "gran" in words[1:]:
        start, tail = words.index("gran") + 1, ["table", job.table]  # of hybrid styles gran is the last
    elif words[0] == "fix" and words[3:4] and words[3].startswith("wall/gran"):
        start, tail = 4, []
    else:
        if words[0] == "pair_style" and any(word.startswith("gran") or "$" in word for word in words[1:]):
            job.leave(f"{' '.join(words[:3])} ...: not a style of LIGGGHTS 3; write `pair_style gran model hertz` first")
        return None
    if words[start : start + 1] != ["model"]:
        unknown = _unknown(words[3 if tail else 4 :])
        why = f"{unknown} has no single value in this input" if unknown else "no word 'model': a style of LIGGGHTS 2"
        return job.leave(f"{' '.join(words[: start + 1])}: {why}; write `model hertz tangential history` here")
    normal, at = (words[start + 1] if len(words) > start + 1 else ""), start + 2
    if normal == "demlaws/table":
        return _other_table(job, words, words.index("table") + 1 if "table" in words else None)
    if not normal or "$" in normal:
        return job.leave(f"model {normal}: no single value in this input; write the model here")
    out = [*words[:start], "model", "demlaws/table"]
    while at < len(words):
        word, value = words[at], words[at + 1] if at + 1 < len(words) else ""
        if word in ("primitive", "mesh"):  # places and sizes, whatever their values
            out += words[at:]
            break
        if word in _SUB_MODELS:
            if (word, value) == ("tangential", "history"):
                value = "demlaws"
                job.note("tangential history is now tangential demlaws, which creates no energy")
            elif "$" in value:
                job.leave(f"{word} {value}: no single value in this input: the model is not converted; write it here")
            elif value not in _SUB_MODELS[word]:
                job.leave(f"{word} {value}: demlaws/table does not run with it; choose one of {', '.join(_SUB_MODELS[word])}")
            out += [word, value]
            at += 2
        elif word in _STOCK_SETTINGS:
            job.note(f"{word} {value} is an option of {normal} and was deleted")
            at += 2
        else:
            if "$" in word:
                job.leave(f"{word}: no single value in this input; write its words here if they name models")
            out.append(word)
            at += 1
    job.note(f"model {normal} is now demlaws/table" + (f" with {job.table}" if tail else ", with the table of the pair style"))
    return out + tail


# --- LAMMPS

_MATERIAL = "hertz/material"
_NORMAL = {
    "hertz": f"it does not name Young's modulus and Poisson's ratio; write {_MATERIAL} E eta nu first",
    "hooke": f"a linear spring; write {_MATERIAL} E eta nu first",
    "jkr": f"cohesion is not available; write {_MATERIAL} E eta nu first, or keep it",
    "dmt": f"cohesion is not available; write {_MATERIAL} E eta nu first, or keep it",
    "mdr": f"plastic and cohesive; write {_MATERIAL} E eta nu first, with the table of a plastic law, or keep it",
}
"""Normal models of LAMMPS that are not converted."""


def _lammps(job, words):
    at = _normal_of(job, words)
    if at is None:
        return None
    normal = words[at] if at < len(words) else ""
    if words[0] == "pair_coeff":
        job.coefficients = True
    if normal == "demlaws/table":
        return _other_table(job, words, at + 1)
    what = f"{' '.join(words[:at])} {normal}"
    if normal in _NORMAL:
        return job.leave(f"{what}: {_NORMAL[normal]}")
    if normal != _MATERIAL:
        if words[0] == "pair_coeff" and not job.granular and (job.granular is False or "$" not in normal):
            return None
        why = "has no single value in this input" if "$" in what else "is not a normal model of LAMMPS"
        return job.leave(f"{what}: {_unknown(words[: at + 1]) or normal or 'nothing'} {why}; write {_MATERIAL} E eta nu here")
    rest = words[at + 1 :]
    with contextlib.suppress(ValueError, IndexError):
        if float(rest[0]) <= 0.0:  # of all types, before lines of some
            return job.leave(f"{what} {rest[0]}: a placeholder without a modulus: write the line of each pair of types instead")
    job.note(f"{_MATERIAL} is now demlaws/table with {job.table}")
    _ask_about_modulus(job, rest[:1], rest[2:3])
    _name_damping(job, rest)
    shear = rest.index("tangential") + 1 if "tangential" in rest else len(rest)
    model = rest[shear] if shear < len(rest) else ""
    if model.startswith("mindlin") and rest[shear + 1 : shear + 2] == ["NULL"]:
        job.note(f"tangential {model} NULL is now tangential demlaws, which creates no energy")
        rest[shear : shear + 2] = ["demlaws"]
    elif "$" in model:
        job.leave(f"tangential {model}: no single value in this input: the model is not converted")
    elif model and model != "demlaws":
        job.note(f"tangential {model} stays")
    return [*words[:at], "demlaws/table", job.table, *rest]


def _name_damping(job, rest):
    """Note the damping that stays: LAMMPS computes it from another stiffness than that on which the rebound depends."""
    damping = rest[rest.index("damping") + 1] if "damping" in rest[:-1] else "viscoelastic"
    if damping in ("tsuji", "coeff_restitution"):
        job.note_once(
            f"damping {damping} stays: it takes the secant stiffness, and a rough contact rebounds by more or less than the "
            "given restitution; write damping demlaws/tangent, which takes the tangent"
        )
    elif damping not in ("none", "demlaws/tangent"):
        job.note_once(f"damping {damping} stays: its number is none of the law's; damping demlaws/tangent takes a restitution")


def _look_at_restart(job):
    """Name the pairs whose models are in a restart file: they keep those, and contacts keep the histories of those."""
    if job.restart is None or job.granular is False:
        return
    job.line, name = job.restart
    file = Path(job.folder or "", job._value(name))
    data = file.read_bytes() if job.folder is not None and file.is_file() else None
    if data is not None and (b"demlaws/table" in data or b"granular" not in data):
        return
    text = "contacts go on with the histories of the models in this file, which are not those of a table"
    if not job.coefficients:
        text = "the models of the pairs are in this file and stay as they are"
    remedy = "start from positions: write_data in the run before, read_data and pair_coeff lines here"
    job.found = True
    if data is None:
        job.note(f"read_restart {name}: unless it is of a run with demlaws/table, {text}; else {remedy}")
    else:
        job.note(f"read_restart {name}: {text}; {remedy}", False)


def _normal_of(job, words):
    """Place of the normal model in the words of a granular command; None of others, and of old styles, which are named."""
    if words[0] == "pair_coeff" and len(words) > 3:
        if not job.hybrid and words[3] != "granular":
            return 3
        if words[3] == "granular":  # hybrid styles name the sub-style, and its number where there are several
            return 5 if words[4:5] and words[4].isdigit() else 4
        if "$" in words[3]:
            job.leave(f"{' '.join(words[:4])}: no single value in this input; write the sub-style here")
        return None
    if words[0] == "fix" and words[3:4] and words[3].startswith("wall/gran"):
        if words[4:5] == ["granular"]:
            return 5
        if _unknown(words[4:5]):
            return 4
        _leave_old(job, words, words[4:5], words[5:6])
    elif words[0] == "pair_style":
        for place, word in enumerate(words[1:], 1):
            if re.match(r"gran/|granular/", word):
                _leave_old(job, words, [word], words[place + 1 : place + 2])
            elif "$" in word:
                job.leave(f"pair_style {word}: no single value in this input; write the style here")
    return None


def _leave_old(job, words, style, stiffness):
    """Name an old style; for Hertz with the modulus that has its stiffness."""
    name = " ".join([*words[: 1 if words[0] == "pair_style" else 4], *style])
    text = f"{name}: an old style; write `granular` with {_MATERIAL} E eta nu first"
    try:
        job.leave(f"{text}, where E/(2 (1 - nu²)) = {0.75 * float(stiffness[0]):g}" if "hertz" in style[0] else text)
    except (ValueError, IndexError):
        job.leave(text)
