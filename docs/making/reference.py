"""The page made from the parsers of the command line."""

import argparse
import os


def _parsers(parser):
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for one in dict.fromkeys(action.choices.values()):
                yield from _parsers(one)


def _choices(parser):
    """Names and lines of the commands of a command."""
    return [
        choice
        for action in parser._actions
        if isinstance(action, argparse._SubParsersAction)
        for choice in action._choices_actions
    ]


COMMON = ("--help", "--json", "--law-file", "--overwrite")
"""Options of most commands, described once."""
FEWEST = 3
"""Fewer arguments that two commands share are shown with both."""
HEAD = """# Commands

`demlaws COMMAND --help` prints the same, with examples. Of every command: `--json` prints the result as JSON
(not of `run`), `--law-file FILE.py` registers [your laws](../own-laws.md), `--overwrite` replaces files that the command did
not write. Values take units (`60.6GPa`). To complete words in bash or zsh: `pip install 'demlaws[completion]'`, then
`eval "$(register-python-argcomplete demlaws)"`. Options that several commands share are described with the first of them.
"""


def shared(parser, described):
    """{earlier command: arguments that it has with the same text and default}; the others are added to `described`."""
    found = {}
    for action in parser._actions:
        if not isinstance(action, argparse._SubParsersAction):
            key = (*(action.option_strings or [action.dest]), action.help, str(action.default))
            found.setdefault(described.setdefault(key, parser.prog), []).append(action)
    found.pop(parser.prog, None)
    return found if sum(map(len, found.values())) >= FEWEST else {}


def groups_of(parser):
    """{title: names of its arguments} of the groups of a parser."""
    return {group.title: [name_of(action) for action in group._group_actions] for group in parser._action_groups}


def name_of(action):
    """The longest name of an argument."""
    return f"`{max(action.option_strings or [action.metavar or action.dest], key=len)}`"


def named(actions, groups):
    """Names of arguments; those of a whole group of the command that describes them by the first and the last."""
    names = [name_of(action) for action in actions]
    for title, members in groups.items():
        if title.startswith("contact") and set(members) <= set(names):
            whole = f"the contact ({members[0]} to {members[-1]})"
            names = [name for name in names if name not in members] + [whole]
    return ", ".join(names)


def brief(parser, described, groups):
    """The help of a parser without usage line, examples, common options and those of earlier commands, which are named."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction) or any(name in COMMON for name in action.option_strings):
            action.help = argparse.SUPPRESS  # each command has a section
    parser._actions = [action for action in parser._actions if action.help != argparse.SUPPRESS]
    groups[parser.prog] = groups_of(parser)
    references = []
    for prog, actions in shared(parser, described).items():
        names = named(actions, groups[prog])
        references.append(f"{names[0].upper()}{names[1:]}: as for [{prog}](#{prog.replace(' ', '-')}).\n")
        for action in actions:
            action.help = argparse.SUPPRESS
    for group in parser._action_groups:
        if all(action.help == argparse.SUPPRESS for action in group._group_actions):
            group.description = None
    parser.epilog = None  # examples, which --help prints
    text = parser.format_help().partition("\n\n")[2].rstrip()
    return "\n".join([*([f"```text\n{text}\n```\n"] if text else []), *references])


def command_page():
    """The help of every command, as its parser gives it; of two engines with the same help that of the first."""
    from demlaws.cli import COMMANDS, build_parser

    os.environ["COLUMNS"] = "92"
    text, described, groups, seen = [HEAD], {}, {}, {}
    for name, (_, line) in COMMANDS.items():
        choices = next(a for a in build_parser((name,))._actions if isinstance(a, argparse._SubParsersAction)).choices
        text.append(f"## demlaws {name}\n")
        if not choices[name].description:
            text.append(f"{line[:1].upper()}{line[1:]}.\n")
        parsers = list(_parsers(choices[name]))
        lines = {f"{parsers[0].prog} {choice.dest}": choice.help for choice in _choices(parsers[0])}
        for number, parser in enumerate(parsers):
            plain = " ".join(parser.format_help().replace(name, "ENGINE").replace(name.upper(), "ENGINE").split())
            first = seen.setdefault(plain, parser.prog)
            if number:
                text.append(f"### {parser.prog}\n")
            if number and not parser.description and first == parser.prog:
                text.append(f"{lines[parser.prog][:1].upper()}{lines[parser.prog][1:]}.\n")
            same = f"As [{first}](#{first.replace(' ', '-')}), for {name.upper()}.\n"
            text.append(brief(parser, described, groups) if first == parser.prog else same)
    return "\n".join(text)
