"""Every `demlaws ...` on a page is valid: the command, its subcommands and its options exist."""

import argparse
import importlib
import re
import shlex
from pathlib import Path

import pytest

from demlaws.cli import COMMANDS, build_parser

PROJECT = Path(__file__).resolve().parents[2]
PAGES = [
    PROJECT / "README.md",
    PROJECT / "CONTRIBUTING.md",
    *(p for p in sorted((PROJECT / "docs").rglob("*.md")) if "made" not in p.parts),
    *(PROJECT / folder / "README.md" for folder in ("yade_scripts", "liggghts_inputs", "lammps_inputs")),
]
LISTING = re.compile(r"^(`{3,})(\w*)\n(.*?)^\1", re.MULTILINE | re.DOTALL)
SPAN = re.compile(r"(?<!`)`(demlaws [^`]+)`(?!`)")
HOLE = re.compile(r"…|\.\.\.")


def typed(text):
    """Command lines of a page's console listings, without what a shell takes of them."""
    for _, kind, listing in LISTING.findall(text):
        if kind != "console":
            continue
        for line in re.sub(r"\\\n\s*", " ", listing).splitlines():
            if line.startswith("$ "):
                line = re.sub(r"\$\([^)]*\)", "X", line[2:].replace("$PWD", "/folder"))
                for part in re.split(r"&&|\||;", line):
                    words = shlex.split(part, comments=True)
                    while words and re.match(r"\w+=", words[0]):
                        words = words[1:]
                    if words[:1] == ["demlaws"]:
                        yield words[1:]


def spoken(text):
    """Command lines in the running text: with holes, and in place of values names."""
    for span in SPAN.findall(LISTING.sub("", text)):
        yield shlex.split(" ".join(span.replace("\\|", "|").split()))[1:]


def refused(words, whole):
    """Why the command line does not take these words, "" if it does; of words with holes or names in place of values, and where
    they are not the whole line, only commands and options are checked."""
    parser, rest = build_parser(tuple(COMMANDS)), list(words)
    while rest and rest[0][:1] != "-":
        below = next((a for a in parser._actions if isinstance(a, argparse._SubParsersAction)), None)
        if below is None:
            break
        for word in [rest[0], *(rest[2::2] if rest[1:2] == ["|"] else [])]:  # build | check: each of them
            if word not in below.choices:
                return f"there is no {parser.prog} {word}"
        parser, rest = below.choices[rest[0]], rest[1:]
    if whole and not any(HOLE.search(word) or word.isupper() for word in rest):
        messages = []

        def stop(status=0, message=None):
            messages.append(message or "")
            raise SystemExit

        parser.exit = stop
        try:
            parser.parse_args(rest)
        except SystemExit:
            return messages[0]
        return ""
    known = {option for action in parser._actions for option in action.option_strings}
    if "SCRIPT" in (parser.usage or ""):  # what stands behind it is the script's own
        rest = rest[: next((n for n, word in enumerate(rest) if word[:1] != "-"), len(rest))]
    unknown = [word for word in rest if re.match(r"-{1,2}[a-z]", word) and word.split("=")[0] not in known]
    return f"{parser.prog} has no {unknown[0]}" if unknown else ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(PROJECT).as_posix())
def test_command_lines_are_taken(page, monkeypatch):
    monkeypatch.setattr(
        importlib.import_module("demlaws.laws.registry"), "load_laws", lambda path: None
    )  # a file that the page writes
    text = page.read_text().partition("\n## [0.")[0]  # a changelog's former versions had other commands
    lines = [(words, True) for words in typed(text)] + [(words, False) for words in spoken(text)]
    assert not [f"demlaws {shlex.join(words)}: {why}" for words, whole in lines if (why := refused(words, whole))]


def test_page_of_commands_has_every_option(monkeypatch):
    """In the section of its command: described there, or named with the command that describes it."""
    from making.reference import COMMON, _parsers, command_page

    monkeypatch.setenv("COLUMNS", "92")  # as the page sets it
    page = command_page()
    sections = {part.partition("\n")[0]: part for part in re.split(r"^#{2,3} ", page, flags=re.MULTILINE)[1:]}
    for command in COMMANDS:
        choices = next(a for a in build_parser((command,))._actions if isinstance(a, argparse._SubParsersAction)).choices
        for parser in _parsers(choices[command]):
            section = sections[parser.prog]
            while same := re.search(r"^As \[(.*?)\]", section, re.MULTILINE):
                section = sections[same[1]]
            visible = [a for a in parser._actions if a.help != argparse.SUPPRESS and a.option_strings[:1] != []]
            names = [max(a.option_strings, key=len) for a in visible]
            if re.search(r"[Tt]he contact \(`--test` to `--hardness`\): as for \[demlaws curve\]", section):
                section += sections["demlaws curve"].partition("contact (SI units")[2]
            assert [name for name in names if name not in COMMON and name not in section] == [], parser.prog
    assert "`--fractal-dimension`, `--hardness`: as for [demlaws curve](#demlaws-curve)" in page
    assert page.count("rms roughness Sq of each surface") == 1
