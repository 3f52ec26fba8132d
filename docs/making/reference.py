"""The page made from the parsers of the command line."""

import argparse
import os


def _parsers(parser):
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in dict.fromkeys(action.choices.values()):
                yield from _parsers(one)


COMMON = ("--help", "--json", "--law-file", "--force")
"""Options of most commands, described once."""
HEAD = """# Commands

`demlaws COMMAND --help` prints the same. Of every command: `--json` prints the result as JSON, `--law-file FILE.py` registers
[user-defined laws](../own-laws.md), `--force` overwrites files that the command did not write. Values take units (`60.6GPa`).
"""


def brief(parser):
    """The help of a parser without its usage line and the common options."""
    for action in parser._actions:
        if any(name in COMMON for name in action.option_strings):
            action.help = argparse.SUPPRESS
    return parser.format_help().partition("\n\n")[2].rstrip()


def command_page():
    """The help of every command, as its parser gives it."""
    from demlaws.cli import COMMANDS, build_parser

    os.environ["COLUMNS"] = "92"
    text = [HEAD]
    for name, (_, line) in COMMANDS.items():
        choices = next(a for a in build_parser((name,))._actions if isinstance(a, argparse._SubParsersAction)).choices
        text.append(f"## demlaws {name}\n\n{line[:1].upper()}{line[1:]}.\n")
        for number, parser in enumerate(_parsers(choices[name])):
            if number:
                text.append(f"### {parser.prog}\n")
            text.append(f"```text\n{brief(parser)}\n```\n")
    return "\n".join(text)
