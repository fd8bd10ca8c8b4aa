"""Write the tables of the reference: `python docs/make_reference.py`.

From the programs' parsers, the types of the settings, the console's commands and the declarations
of the state. A test fails when a page is out of date.
"""

import argparse
import json
import re
from collections import Counter
from collections.abc import Iterator
from inspect import cleandoc
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import inspect

import capture.cli.main
import subsea.cli.main
from subsea.base.command_line import NumberReader
from subsea.base.files import replacing
from subsea.dive.settings import CONTROLS, Settings
from subsea.stage.console import commands as console
from subsea.state import GROUPS, declared

HERE = Path(__file__).parent
BEGIN, END = "<!-- made by docs/make_reference.py -->\n", "<!-- end of what is made -->\n"


def main() -> None:
    """Rewrite the pages."""
    for name in MADE:
        with replacing(HERE / name) as temporary:
            temporary.write_text(page(name), encoding="utf-8")


def page(name: str) -> str:
    """A page: its own text, and the generated part between the marks."""
    before, _, rest = (HERE / name).read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    return before + BEGIN + "".join(f"{line}\n" for line in MADE[name]()) + END + after


def commands() -> Iterator[str]:
    """List all commands of both programs."""
    parsers = [
        parser
        for program in (subsea.cli.main, capture.cli.main)
        for parser in program.parsers()[1].choices.values()
    ]
    yield from ("", "| command | what |", "| --- | --- |")
    for parser in parsers:
        summary, _ = described(parser)
        yield f"| [`{parser.prog}`](#{parser.prog.replace(' ', '-')}) | {summary} |"
    common = shared_options(parsers)
    yield from ("", "## Shared options", "", "| option | what |", "| --- | --- |")
    yield from common.values()
    for parser in parsers:
        yield from command(parser, common)
    yield ""


def shared_options(parsers: list[argparse.ArgumentParser]) -> dict[str, str]:
    """The rows of options that several commands have with one meaning, by option.

    Of an option with other meanings, the row that three or more commands have.
    """
    rows: dict[str, Counter[str]] = {}
    for parser in parsers:
        for action in parser._actions:
            if action.option_strings and action.dest != "help":
                rows.setdefault(action.option_strings[0], Counter())[option_row(action)] += 1
    usual = {name: (*has.most_common(1)[0], len(has)) for name, has in rows.items()}
    return {
        name: row for name, (row, count, kinds) in usual.items() if count > (1 if kinds == 1 else 2)
    }


def option_row(action: argparse.Action) -> str:
    """The row of an argument or option in a table."""
    return f"| {names(action)} | {cell(meaning(action))} |"


def command(parser: argparse.ArgumentParser, common: dict[str, str]) -> Iterator[str]:
    """Describe a command, its options and examples; `common` ones by name only."""
    summary, text = described(parser)
    positional = [usage(action) for action in parser._actions if not action.option_strings]
    yield from ("", f"## {parser.prog}", "")
    yield f"{summary}.{' ' * bool(text)}{paragraphs(text)}"
    yield from ("", "```text", " ".join([parser.prog, *positional, "[OPTION]…"]), "```")
    for group in parser._action_groups:
        rows = [action for action in group._group_actions if action.dest != "help"]
        if not rows:
            continue
        title = (group.title or "").capitalize()
        if group.title not in ("positional arguments", "options"):
            yield from ("", f"{title}: {linked(group.description or '')}".removesuffix(": "))
        kind = "argument" if group.title == "positional arguments" else "option"
        own = [action for action in rows if option_row(action) not in common.values()]
        if own:
            yield from ("", f"| {kind} | what |", "| --- | --- |", *map(option_row, own))
        also = [f"`{action.option_strings[0]}`" for action in rows if action not in own]
        if also:
            yield from ("", f"[Shared options](#shared-options): {', '.join(also)}")
    examples = (parser.epilog or "").partition("examples:\n")[2].splitlines()
    yield from ("", "```sh", *(example.strip() for example in examples), "```")


def paragraphs(text: str) -> str:
    """A description without line breaks; indented lines become a list."""
    text = re.sub(r"\n {3,}", " ", text)
    text = re.sub(r"\n  (\w+) +", r"\n\n- `\1`: ", text)
    text = re.sub(r"(\n- .*)\n(?=\w)", r"\1\n\n", text)
    text = re.sub(r"(?<!\n)\n(?!\n)", " ", text)
    return linked(re.sub(r"(- .*)\n\n(?=- )", r"\1\n", text))


def described(parser: argparse.ArgumentParser) -> tuple[str, str]:
    """The summary and the description of a command."""
    summary, _, text = (parser.description or "").partition("\n\n")
    return summary.removesuffix("."), text


def usage(action: argparse.Action) -> str:
    """An argument in a usage line."""
    name = str(action.metavar or action.dest)
    more = {"*": f"[{name}…]", "?": f"[{name}]", "+": f"{name}…"}
    return more.get(str(action.nargs), name)


def names(action: argparse.Action) -> str:
    """The syntax of an argument or option."""
    if not action.option_strings:
        return f"`{cell(usage(action))}`"
    value = action.metavar or "|".join(action.choices or ())
    value = " ".join(value) if isinstance(value, tuple) else value
    value = "" if action.nargs == 0 else f" [{value}]" if action.nargs == "?" else f" {value}"
    return ", ".join(f"`{option}{cell(value)}`" for option in action.option_strings)


def meaning(action: argparse.Action) -> str:
    """The help of an argument, its range and whether it is optional."""
    words = [linked(action.help or "")]
    if isinstance(action.type, NumberReader):
        words.append(action.type.expected)
    if action.option_strings and action.required:
        words.append("must be given")
    if isinstance(action, argparse._AppendAction) and "several" not in words[0]:
        words.append("may be given several times")
    return "; ".join(word for word in words if word)


def linked(text: str) -> str:
    """Replace names of pages by links."""
    return re.sub(r"docs/([\w-]+/([\w-]+)\.md)", r"[\2](../\1)", text)


def cell(text: str) -> str:
    """Escape text for a cell of a table."""
    return text.replace("|", " or ")


def settings() -> Iterator[str]:
    """List all tables of a settings file."""
    for table in inspect.type_info(Settings).fields:  # type: ignore[attr-defined]
        yield from ("", f"## `[{table.encode_name}]`", "")
        if table.encode_name == "controls":
            yield from controls()
            continue
        yield from (
            table.type.extra_json_schema["description"],
            "",
            "| key | default | range | what |",
            "| --- " * 4 + "|",
        )
        for field in table.type.type.fields:
            about = (field.type.extra_json_schema or {})["description"]
            about = re.sub(r"^[\d.]+ to [\d.]+: ", "", about)
            default = json.dumps(field.default)
            yield f"| `{field.encode_name}` | `{default}` | {span(field.type.type)} | {about} |"
    yield ""


def controls() -> Iterator[str]:
    """List the action of each input."""
    yield (
        "The inputs of each control, as a list. Keys are named by their place on a US "
        "keyboard, alone or as `Ctrl+Shift+Q`; `mouse left`, `right`, `middle`, 4 to 8; the parts "
        "of a gamepad as here."
    )
    yield from ("", "| key | default | what |", "| --- | --- | --- |")
    for name, control in CONTROLS.items():
        key = name if name.isidentifier() else json.dumps(name)
        yield f"| `{key}` | `{json.dumps(list(control.inputs))}` | {control.what} |"


def span(kind: Any) -> str:
    """The range of a value."""
    match kind:
        case inspect.BoolType():
            return "true, false"
        case inspect.LiteralType(values):
            return ", ".join(str(value) for value in values)
        case inspect.TupleType(parts):
            return f"two numbers, {span(parts[0])}"
        case inspect.IntType() | inspect.FloatType():
            return f"{kind.ge:g} to {kind.le:g}"
    return "text"


def state() -> Iterator[str]:
    """List all arrays of the state."""
    for part, group in GROUPS.items():
        yield from ("", f"## `{part}`", "", cleandoc(group.__doc__ or ""), "")
        yield from ("| array | type | written by | start | meaning |", "| --- " * 5 + "|")
        for name, spec in declared(group).items():
            shape = f"({', '.join(map(str, spec.shape))})" if spec.shape else "number"
            kind = f"{spec.dtype.name} {shape} {spec.unit}".rstrip()
            start = ", ".join(f"{value:g}" for value in np.ravel(spec.start))
            yield f"| `{name}` | {kind} | {spec.writer} | {start} | {cell(spec.about)} |"
    yield ""


def console_commands() -> Iterator[str]:
    """List the commands of the presenter's console."""
    yield from ("", "| command | what | keys |", "| --- | --- | --- |")
    for one in console.described():
        keys = [f"`{key['name']}`: {key['about']}" for key in one["parameters"]]
        yield f"| `{one['command']}` | {one['what']} | {'; '.join(keys)} |"
    yield ""


MADE = {
    "reference/console-interface.md": console_commands,
    "reference/commands.md": commands,
    "reference/settings.md": settings,
    "reference/state.md": state,
}

if __name__ == "__main__":
    main()
