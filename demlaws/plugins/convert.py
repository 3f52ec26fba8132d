"""Inputs of LIGGGHTS and LAMMPS with their contact model replaced by demlaws/table.

Changed are pair_style, pair_coeff, wall and surface lines that have their models in words, and delete_atoms. Every other line
that has, or includes, stock models of grains, or that stops a run with demlaws/table, stays as it is and is named with its
number and what to write by hand.
"""

import copy
import itertools
import math
import os
import re
from pathlib import Path
from typing import NamedTuple

from demlaws.errors import DemlawsError
from demlaws.files import read_text, write_atomically
from demlaws.plugins import styles


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


class Table(NamedTuple):
    """A table file, as the input names it."""

    name: str
    law: str = ""
    modulus: float | None = None  # E* that it was made for [Pa]
    roughness: float | None = None  # σ on which its curve depends [m]
    collapses: bool = True  # it serves other moduli, too


class NotConverted(Exception):
    """A line that stays: the reason and the remedy."""


_WHOLE_LINE = re.compile(r"(?:.*&[ \t]*\n)*.*\n?")
"""A line, with those that follow one that ends in &."""
_CODE = re.compile(r"""(?:"[^"]*"|'[^']*'|[^#"'])*""")
"""The part before a comment: a # in quotes begins none."""
_NAME = re.compile(r"[^\s\"'#$&]+")
_FILLS = ("create_box", "read_data", "read_restart")
"""Commands of a whole input."""
_BY_HAND = "write the words of the model here"
_MODULI = (
    "Young's moduli stay; the table is for E* = E/(2(1 - nu²)) = {:.4g} Pa: if the moduli of the input differ, so does the "
    "effect of roughness; give the modulus of the grains, or a table for softened grains (`demlaws soften`)"
)


def convert(text, engine, table, folder=None, name="", pairs=None):
    """The input `text` of an engine ("liggghts" or "lammps") with the law of `table`, a `Table` or its name in the input.

    folder: where the files that the input includes are; name: of the input; pairs: {(I, J): `Table`} of types with their own.
    """
    work = {"liggghts": _Liggghts, "lammps": _Lammps}[engine](table, pairs or {}, folder, name)
    lines, changed = [], False
    for number, line, code, words in _commands(text.replace("\r\n", "\n")):
        new, remarks = work.line(number, words)
        if new != [words]:
            modulus = work.tables[None].modulus
            remarks += [_MODULI.format(modulus)] if modulus and not work.converted and "demlaws/table" in new[0] else []
            work.converted |= "demlaws/table" in new[0]
            comment = line[len(code) :].strip()
            line, changed = "\n".join(" ".join(each) for each in new) + f" {comment}".rstrip() + "\n", True
        work.notes += [Note(number, remark) for remark in remarks]
        lines.append(line)
    work.look_at_all()
    if not work.granular or not work.notes:
        raise DemlawsError(
            f"no pair_style, pair_coeff or wall line with a granular model of {engine.upper()} in this input: nothing to "
            "convert (lines with demlaws/table get another table by hand)"
        )
    return Converted("".join(lines), sorted(work.notes, key=lambda note: note.line), changed)


def convert_file(path, engine, table, *, out=None, pairs=None):
    """Convert the input `path` and write it as `out` (default: beside it, with .demlaws at its end); (out, `Converted`).

    `table` and those of `pairs`, {(I, J): table of these types}, are paths from here; in the input they are named as seen from
    the folder of `out`, where the engine runs. If no line can be converted, no file is written, and `out` is None.
    """
    path = Path(path)
    out = path.with_name(path.name + ".demlaws") if out is None else Path(out)
    read = {types: _read_table(Path(each), out.parent) for types, each in {None: table, **(pairs or {})}.items()}
    conversion = convert(read_text(path), engine, read.pop(None), path.parent, path.name, read)
    if not conversion.changed:
        return None, conversion
    write_atomically(out, conversion.text)
    return out, conversion


def _read_table(path, folder):
    from demlaws.curves.table_grammar import parse

    if not path.is_file():
        raise DemlawsError(f"table {path} does not exist; `demlaws table` writes one")
    values = parse(path.read_bytes(), path)[0][0].values
    sigma = values["sigma"] if values["length"] == "sigma" else None
    return Table(os.path.relpath(path, folder), values["law"], values["modulus"], sigma, values["collapses"] == "yes")


def _commands(text):
    """(number, line, its code, words of the code) of each command of an input."""
    for whole in _WHOLE_LINE.finditer(text):
        code = _CODE.match(whole[0])[0]
        yield text.count("\n", 0, whole.start()) + 1, whole[0], code, re.sub(r"&[ \t]*\n", " ", code).split()


class _Input:
    """An input that is read command by command."""

    engine: str

    def __init__(self, table, pairs, folder, name):
        self.tables = {None: table if isinstance(table, Table) else Table(str(table))}
        self.tables |= {(min(types), max(types)): each for types, each in pairs.items()}
        self.folder, self.name, self.included = folder, name, {name}
        self.variables, self.facts = {}, {}  # shared with included files; facts: name → number of its line
        self.notes, self.models, self.converted, self.granular = [], [], False, False
        for each in self.tables.values():
            self._check_name(each.name)

    def _check_name(self, name):
        if re.search(r"\s", name):
            raise DemlawsError(f"table {name!r}: engines do not accept names with spaces; rename the file")
        if not _NAME.fullmatch(name) or (self.engine == "lammps" and not name.isascii()):
            raise DemlawsError(
                f"table {name!r}: {self.engine.upper()} changes this name (quotes, #, $, &, and in LAMMPS letters that are not "
                "ASCII); rename the file or its folder"
            )

    def line(self, number, words):
        """(words of the commands in place of this one, remarks); a command that stays is noted."""
        try:
            return self.command(number, words)
        except NotConverted as left:
            self.notes.append(Note(number, str(left), False))
            return [words], []

    def command(self, number, words):
        """(words of the commands in place of this one, remarks). Raises NotConverted."""
        first, other = [*words, "", ""][:2]
        text = " ".join(words)
        self._keep_facts(number, words)
        for pattern, reason in styles.STOPS[self.engine]:
            if re.match(pattern, text):
                raise NotConverted(f"{text}: {reason}")
        self._check_style(first, words)
        if first in ("pair_style", "pair_coeff", "fix"):
            return self.model(number, words)
        if first in ("include", "jump") and other not in ("SELF", self.name):
            self._include(first, other)
        elif first == "read_restart":
            return [words], [f"{first} {other}: unless this file is of a run with demlaws/table, {self.restart}"]
        elif first == "delete_atoms" and " compress no" not in text:
            return [[*re.sub(r" compress \S+", "", text).split(), "compress", "no"]], [
                "delete_atoms now has `compress no`: with new numbers of the particles contacts would lose their histories"
            ]
        elif "$" in first:
            self.granular = True
            raise NotConverted(f"{first}: a command by variable; write it here if it is a granular one")
        elif first != "print" and (model := styles.ELSEWHERE[self.engine].search(text)):
            self.granular |= model[0] != "delete_atoms"
            raise NotConverted(f"{first} ... {model[0]}: convert does not read this command; change it yourself")
        return [words], []

    def _keep_facts(self, number, words):
        first = words[0] if words else ""
        if first == "variable" and words[2:3] and words[2] in ("equal", "index", "string", "internal", "universe", "loop"):
            self.variables.setdefault(words[1], " ".join(words[3:4]))
        elif first in ("units", *_FILLS):
            self.facts.setdefault(first, number)

    def _check_style(self, first, words):
        """Raises NotConverted for a granular style that demlaws/table cannot replace."""
        at = {"pair_style": 1, "fix": 3, "compute": 3, "dump": 3}.get(first, len(words))
        found = words[at : at + 1]
        if first == "pair_style":  # of hybrid styles there are several
            found = itertools.takewhile(lambda word: word != "model", words[at:])
        for style in found:
            plain = re.sub(r"/(omp|kk|gpu|intel|opt)$", "", style)
            if not styles.GRANULAR[self.engine].search(plain):
                continue
            self.granular = True
            known = styles.STYLES[self.engine][first]
            if reason := known.get(plain, "a style that convert does not know: write one of the engine's documentation first"):
                raise NotConverted(f"{first} {style}: {reason}")

    def _include(self, first, other):
        if other in self.included:
            return
        self.included.add(other)
        file = Path(self.folder or "", other)
        remains = self.folder is None or not file.is_file()
        if not remains:
            inner = copy.copy(self)
            inner.notes, inner.models = [], []
            for number, _, _, words in _commands(read_text(file)):
                remains |= inner.line(number, words)[0] != [words]
            remains |= not all(note.served for note in inner.notes)
            self.granular |= inner.granular
        if remains:
            self.granular = True
            raise NotConverted(
                f"{first} {other}: if that file has granular lines, also in a file that it includes, convert it, too, and "
                "write its new name here"
            )

    def number(self, word):
        """A number of an input line, also by variable; None: unknown."""
        for _ in range(9):
            name = re.fullmatch(r"\$\{(\w+)\}|\$(\w)|v_(\w+)", word)
            word = self.variables.get(name[name.lastindex], "") if name else word
        try:
            return float(word)
        except ValueError:
            return None

    def note(self, number, text):
        """Name a line that stops or changes the run."""
        self.notes.append(Note(number, text, False))

    @property
    def fills(self):
        """The first command that makes or reads particles; "": this is a part of an input."""
        return next((name for name in _FILLS if name in self.facts), "")

    def look_at_all(self):
        """Notes on what depends on several lines."""
        if self.fills not in ("", "read_restart") and "units" not in self.facts and self.granular:
            self.note(
                self.facts[self.fills],
                "no units line: the default is lj, and tables are in metres; write the input in `units si`",
            )

    @property
    def fixed(self):
        """Whether the table is of one pair of materials: its law has a length, or does not collapse."""
        table = self.tables[None]
        return bool(table.modulus) and (not table.collapses or table.roughness is not None)

    def other_materials(self, materials):
        """Name those that would get the table of another pair of materials; materials: [(line, name, E*)]."""
        table = self.tables[None]
        known = [modulus for _, _, modulus in materials if modulus]
        nearest = min(known, key=lambda modulus: abs(math.log(modulus / table.modulus)), default=None)
        sigma = f" and σ = {table.roughness:.3g} m" if table.roughness else ""
        for number, name, modulus in materials:
            if modulus and math.isclose(modulus, nearest, rel_tol=1e-3):
                continue
            self.note(
                number,
                f"{name}: E* = {f'{modulus:.4g} Pa' if modulus else 'unknown'}, another pair of materials than that of "
                f"{table.name} with E* = {table.modulus:.4g} Pa{sigma}: give it a table of its own with --table I J FILE "
                "(`demlaws table --young E1 E2 --poisson NU1 NU2 --roughness SQ1 SQ2 ...`)",
            )

    restart: str

    def model(self, number, words):
        raise NotImplementedError


class _Liggghts(_Input):
    engine = "liggghts"
    restart = "LIGGGHTS stops: its contacts keep other values; start from positions (write_data, read_data)"

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.properties = {}  # name → (line, values)

    def _keep_facts(self, number, words):
        super()._keep_facts(number, words)
        if words[:1] == ["fix"] and words[3:4] == ["property/global"] and len(words) > 6:
            self.properties[words[4]] = number, words[6:]

    def model(self, number, words):
        style = words[3] if words[0] == "fix" and len(words) > 3 else " ".join(words[1:])
        pairs = words[0] == "pair_style"
        if pairs and "gran" in words[1:]:
            start = words.index("gran") + 1
        elif style == "wall/gran":
            start = 4
        elif style.startswith("wall/gran") or (pairs and words[1:2] and words[1] not in styles.OTHER_PAIRS):
            self.granular = True
            raise NotConverted(
                f"{' '.join(words[:4])}: not a style of LIGGGHTS 3 in words; write `gran model hertz tangential history`"
            )
        else:
            return [words], []
        self.granular = True
        head, normal = [*words[start:], "", ""][:2]
        if head != "model" or "$" in normal:
            raise NotConverted(f"{' '.join(words[: start + 2])}: {_BY_HAND}: `model hertz tangential history`")
        if normal == "demlaws/table":
            return [words], []
        lacks = self._may_replace(normal)
        out, remarks = self._settings(words[start + 2 :], normal)
        self.models.append(number)
        own = ["table", self.tables[None].name] if pairs else []
        for (i, j), table in ((types, table) for types, table in self.tables.items() if types and pairs):
            own += ["pairtable", str(i), str(j), table.name]
        source = f"with {self.tables[None].name}" if pairs else "with the table of the pair style"
        remarks.append(f"model {normal} is now demlaws/table, {source}{lacks}")
        return [[*words[:start], "model", "demlaws/table", *out, *own]], remarks

    def _may_replace(self, normal):
        """Text on what the law lacks that replaces a normal model."""
        model = styles.NORMALS[self.engine].get(normal)
        if model is None:
            raise NotConverted(
                f"model {normal}: a model that convert does not know; demlaws/table would drop what it adds to hertz"
            )
        if model.law == "any":
            return ""
        if not model.law:
            raise NotConverted(f"model {normal} {model.lacks}")
        without = f" without {model.lacks}" if model.lacks else ""
        if any(table.law != model.law for table in self.tables.values()):
            raise NotConverted(
                f"model {normal}: the nearest law is {model.law}{without}: `demlaws table --law {model.law} "
                f"{model.options} ... --out FILE`; with its table convert replaces this line"
            )
        return f", law {model.law}{without}"

    def _settings(self, words, normal):
        """(words behind the normal model for demlaws/table, remarks)."""
        out, remarks, places = [], [], False
        at = 0
        while at < len(words):
            word, value = [*words[at:], ""][:2]
            places |= word in ("primitive", "mesh")  # behind these come places and sizes, then settings of the models again
            if word in styles.STOCK_SETTINGS:
                remarks.append(f"{word} {value} is an option of {normal} and was deleted")
                at += 2
                continue
            if places:
                out.append(word)
                at += 1
                continue
            allowed = styles.SUB_MODELS.get(word)
            if "$" in word or ("$" in value and allowed):
                raise NotConverted(f"{word} {value}: {_BY_HAND}")
            if allowed and value not in allowed:
                raise NotConverted(f"{word} {value}: demlaws/table does not run with it; choose one of {', '.join(allowed)}")
            if not allowed and word not in styles.SETTINGS:
                raise NotConverted(
                    f"{word} {value}: no setting of demlaws/table; leave it out, and styles after gran before it"
                )
            if (word, value) == ("tangential", "history"):
                remarks.append("tangential history is now tangential demlaws, which creates no energy")
                value = "demlaws"
            out += [word, value]
            at += 2
        return out, remarks

    def look_at_all(self):
        super().look_at_all()
        if not self.models:
            return
        missing = [name for name in styles.PROPERTIES if name not in self.properties]
        if missing and self.fills:
            self.note(
                self.models[0],
                f"demlaws/table needs fix property/global {', '.join(missing)}, which this input does not define",
            )
        young, poisson = (self.properties.get(name, (0, [])) for name in styles.PROPERTIES[:2])
        moduli = [(e, n) for e, n in zip(young[1], poisson[1], strict=False)]
        highest = max((types[1] for types in self.tables if types), default=0)
        if moduli and highest > len(moduli):
            raise DemlawsError(f"--table names type {highest}, the input has {len(moduli)} types")
        if len(set(moduli)) < 2 or not self.fixed:
            return
        found = []
        for i, j in itertools.combinations_with_replacement(range(1, len(moduli) + 1), 2):
            values = [self.number(word) for word in (*moduli[i - 1], *moduli[j - 1])]
            modulus = None if None in values else _effective(*values)
            if (i, j) not in self.tables:
                found.append((young[0], f"types {i} and {j}", modulus))
        self.other_materials(found)


class _Lammps(_Input):
    engine = "lammps"
    restart = (
        "its pairs keep the models and histories that are in it: start from positions (write_data in the run before, read_data "
        "and pair_coeff lines here)"
    )

    def _keep_facts(self, number, words):
        super()._keep_facts(number, words)
        if words[:1] == ["pair_style"]:
            self.facts["hybrid"], self.facts["pairs"] = " ".join(words[1:2]).startswith("hybrid"), "granular" in words

    def model(self, number, words):
        at = self._normal_at(words)
        normal = words[at] if at < len(words) else ""
        if not normal:
            return [words], []
        self.granular = True
        if normal == "demlaws/table":
            return [words], []
        model = styles.NORMALS[self.engine].get(normal)
        if "$" in normal or not model:
            raise NotConverted(
                f"{' '.join(words[: at + 1])}: no normal model that convert knows; write hertz/material E eta nu here first"
            )
        if not model.law:
            raise NotConverted(f"{' '.join(words[: at + 1])}: {normal} {model.lacks}")
        if words.count("model") > 1:
            raise NotConverted(
                f"{' '.join(words[:4])}: LAMMPS mixes the histories of several models up; write one fix per model"
            )
        if len(words) < at + 4:
            raise NotConverted(f"{' '.join(words)}: {normal} needs E eta nu")
        rest, remarks = self._sub_models(words[at + 1 :])
        out = []
        for types, table in self._tables_of(words):
            line = [*words[:at], "demlaws/table", table.name, *rest]
            line[1:3] = map(str, types) if types else line[1:3]
            out.append(line)
            self.models.append((number, line, at, table is self.tables[None]))
        names = ", ".join(dict.fromkeys(line[at + 1] for line in out))
        return out, [f"{normal} is now demlaws/table with {names}", *remarks]

    def _normal_at(self, words):
        """Place of the normal model in the words of a command; their number if it has none. Raises NotConverted."""
        if words[0] == "pair_style":
            if any("$" in word for word in words[1 : 2 + self.facts["hybrid"]]):
                self.granular = True
                raise NotConverted(f"{' '.join(words[:3])}: a style by variable; write it here")
            return len(words)
        if words[0] == "pair_coeff":
            if words[3:4] == ["granular"]:  # hybrid styles name it, and its number where there are several
                return 5 if words[4:5] and words[4].isdigit() else 4
            if words[3:4] == ["surf/granular"]:
                raise NotConverted(f"{' '.join(words[:5])}: {styles.STYLES[self.engine]['pair_style']['surf/granular']}")
            known = [*styles.NORMALS[self.engine], "demlaws/table"]
            asked = self.facts.get("pairs", words[3:4] and words[3] in known)
            return 3 if asked and not self.facts.get("hybrid") else len(words)
        style = words[3] if len(words) > 3 else ""
        if "$" in style:
            return len(words)
        if style == "surface/global":
            at = words.index("model") + 3 if "model" in words else 4
        elif style.startswith("wall/gran"):
            at = 4
        else:
            return len(words)
        if words[at : at + 1] != ["granular"]:
            self.granular = True
            raise NotConverted(
                f"{' '.join(words[:4])}: an old style, or one by variable; write `granular` and hertz/material E eta nu first"
            )
        return at + 1

    @staticmethod
    def _sub_models(words):
        """(words behind the normal model, remarks)."""
        rest, remarks = list(words), []
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
        return rest, remarks

    def _tables_of(self, words):
        """[(types, table)] of the lines in place of one; types None: those of the line."""
        own = [(types, table) for types, table in self.tables.items() if types and _covers(words, types)]
        if own and all(word.isdigit() for word in words[1:3]):
            return [(None, own[0][1])]
        return [(None, self.tables[None]), *own]

    def look_at_all(self):
        super().look_at_all()
        lines = [model[:3] for model in self.models if model[1][0] == "pair_coeff"]
        for number, line, _ in lines[1:]:
            if _history(line) != _history(lines[0][1]):
                self.note(
                    number,
                    f"{' '.join(line[:3])}: tangential, rolling and twisting models that keep another number of history values "
                    f"than those of line {lines[0][0]}, which LAMMPS mixes up: give all pair_coeff lines the same",
                )
        self._look_at_mixed(lines)
        moduli, found = set(), []
        for number, line, at, default in self.models:
            young, _, poisson = line[at + 2 : at + 5]
            moduli.add((young, poisson))
            values = self.number(young), self.number(poisson)
            if default:
                found.append((number, " ".join(line[:3]), None if None in values else _effective(*values, *values)))
        if len(moduli) > 1 and self.fixed:
            self.other_materials(found)

    def _look_at_mixed(self, lines):
        """Name types that LAMMPS would mix: they need a table of their own, or have tables that cannot be mixed."""
        like = {line[1]: (number, line, at) for number, line, at in lines if line[1] == line[2] and line[1].isdigit()}
        for (i, (_, one, at)), (j, (number, other, _)) in itertools.combinations(sorted(like.items()), 2):
            types = int(i), int(j)
            equal = one[at + 2 : at + 5 : 2] == other[at + 2 : at + 5 : 2] or not self.fixed
            mixes = one[at + 1] == other[at + 1] and types not in self.tables and equal
            if mixes or any(_covers(line, types) for _, line, _ in lines):
                continue
            file = self.tables[types].name if types in self.tables else "FILE"
            new = ["pair_coeff", i, j, *one[3 : at + 1], file, *one[at + 2 : at + 5]]
            new += [] if equal else ["against", other[at + 2], other[at + 4]]
            self.note(
                number,
                f"types {i} and {j} have no line, and LAMMPS cannot mix theirs: add `{' '.join([*new, *one[at + 5 :]])}`",
            )


_KEEPS = {"none": 0, "linear_nohistory": 0, "mindlin_rescale": 4, "mindlin_rescale/force": 4, "demlaws": 12}
"""History values of the tangential models of LAMMPS; the others keep 3."""


def _history(line):
    """What distinguishes the history of a pair_coeff line of LAMMPS."""
    tangential, rolling, twisting = (
        line[line.index(word) + 1] if word in line[:-1] else "none" for word in ("tangential", "rolling", "twisting")
    )
    return _KEEPS.get(tangential, 3), rolling, twisting


def _covers(line, types):
    """Whether the ranges of types of a pair_coeff line have a pair, the lower type first."""

    def has(word, number):
        low, star, high = word.partition("*")
        if not star or not (low + high or "0").isdigit():
            return word == str(number)
        return (not low or number >= int(low)) and (not high or number <= int(high))

    return line[0] == "pair_coeff" and all(map(has, line[1:3], types))


def _effective(young1, poisson1, young2, poisson2):
    """E* of two bodies [Pa]."""
    return 1.0 / ((1.0 - poisson1**2) / young1 + (1.0 - poisson2**2) / young2)
