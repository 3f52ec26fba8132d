"""The page made from the parsers of the command line."""

import argparse
import os


def _parsers(parser):
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in dict.fromkeys(action.choices.values()):
                yield from _parsers(one)


def command_page():
    """The help of every command, as its parser gives it."""
    from demlaws.cli import COMMANDS, build_parser

    os.environ["COLUMNS"] = "92"
    text = ["# Commands\n"]
    for name, (_, line) in COMMANDS.items():
        choices = next(a for a in build_parser((name,))._actions if isinstance(a, argparse._SubParsersAction)).choices
        text.append(f"## demlaws {name}\n\n{line[:1].upper()}{line[1:]}.\n")
        for number, parser in enumerate(_parsers(choices[name])):
            if number:
                text.append(f"### {parser.prog}\n")
            text.append(f"```text\n{parser.format_help().rstrip()}\n```\n")
    return "\n".join(text)
