"""Pages made from the parsers of the command line and from the errors that the code raises."""

import argparse
import ast
import os
from pathlib import Path

from making.theory import table

ROOT = Path(__file__).resolve().parents[2]

AREAS = {
    "cli": "Command line",
    "yade": "In YADE",
    "liggghts": "In LIGGGHTS",
    "lammps": "In LAMMPS",
    "laws": "Laws",
    "core": "Laws",
    "solvers": "Height maps and solved contacts",
    "advice": "Choosing and fitting",
    "measure": "Measuring",
    "validation": "Measuring",
    "plots": "Figures",
}


def _parsers(parser):
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in dict.fromkeys(action.choices.values()):
                yield from _parsers(one)


def command_pages(folder):
    """A page a command, its help as the parser gives it; returns the names."""
    from demlaws.cli import COMMANDS, build_parser

    folder.mkdir(parents=True, exist_ok=True)
    os.environ["COLUMNS"] = "92"
    for name, (_, line) in COMMANDS.items():
        choices = next(a for a in build_parser((name,))._actions if isinstance(a, argparse._SubParsersAction)).choices
        text = [f"# demlaws {name}\n", f"{line[:1].upper()}{line[1:]}.\n"]
        for number, parser in enumerate(_parsers(choices[name])):
            if number:
                text.append(f"## {parser.prog}\n")
            text.append(f"```text\n{parser.format_help().rstrip()}\n```\n")
        (folder / f"{name}.md").write_text("\n".join(text))
    return list(COMMANDS)


def _words(node):
    """Text of a message in the source; inserted values are shown as ‹expression›."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(_words(part) for part in node.values)
    if isinstance(node, ast.FormattedValue):
        return f"‹{ast.unparse(node.value)}›"
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return _words(node.left) + _words(node.right)
    return f"‹{ast.unparse(node)}›"


def messages():
    """(file, class of the error, message) of every error of ours with a text of its own, in the order of the source."""
    from demlaws import errors

    ours = {name for name, kind in vars(errors).items() if isinstance(kind, type) and issubclass(kind, (Exception, Warning))}
    found = []
    for path in sorted((ROOT / "demlaws").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Raise) or not isinstance(node.exc, ast.Call) or not node.exc.args:
                continue
            called = node.exc.func
            kind = called.id if isinstance(called, ast.Name) else getattr(called, "attr", "")
            text = _words(node.exc.args[0])
            if (kind in ours or kind == "ArgumentTypeError") and any(c.isalpha() for c in _without_holes(text)):
                found.append((path.relative_to(ROOT / "demlaws"), kind, text))
    return found


def _without_holes(text):
    kept, depth = [], 0
    for sign in text:
        depth += (sign == "‹") - (sign == "›")
        if depth == 0 and sign != "›":
            kept.append(sign)
    return "".join(kept)


def error_page():
    """All messages, by part of the package."""
    areas = {}
    for path, _, text in messages():
        area = AREAS.get(path.parts[0], "Quantities, contacts, tables, paths")
        shown = "`" + text.replace("`", "'").replace("\n", " ").strip() + "`"
        areas.setdefault(area, {}).setdefault(shown, str(path))
    text = [
        "# Error messages\n",
        "Every error that demlaws raises itself is a `DemlawsError` (also a `ValueError`); the commands print "
        "it as one line and end with status 2. The remedy is in the message, after the colon or the semicolon; ‹…› is an "
        "inserted value. "
        "This page is generated; messages of libraries are not included. A `ValidityWarning` is issued if a law "
        "is used outside the range of its source; results are returned.\n",
    ]
    for area in sorted(areas):
        text.append(f"## {area}\n")
        text.append(table(["message", "from"], [(message, f"`{path}`") for message, path in areas[area].items()]))
    return "\n".join(text)
