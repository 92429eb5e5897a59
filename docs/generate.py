#!/usr/bin/env python3
"""Writes the pages of docs/reference that follow from the program and from schemas/.

    python3 docs/generate.py [--check] [--rrf target/release/rrf]

--check writes nothing and fails where a page differs from what would be written."""

import argparse
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs/reference"
NOTE = "<!-- Made by docs/generate.py; not to be changed by hand. -->\n"
# the order of a run's journey; schemas that are not listed follow
TABLES = ["samples", "tree", "weights", "metrics", "steps", "tasks", "points", "truth", "answers"]


def help_text(rrf, *command):
    done = subprocess.run([rrf, *command, "--help"], capture_output=True, text=True, check=True)
    # trailing spaces of empty lines are clap's
    return "\n".join(line.rstrip() for line in done.stdout.splitlines()).strip()


def subcommands(rrf):
    listed = help_text(rrf).split("Commands:")[1].split("Options:")[0]
    names = re.findall(r"^ {2}([a-z-]+) ", listed, re.MULTILINE)
    return [name for name in names if name != "help"]


def command_line(rrf):
    parts = [NOTE + "# Command line\n"]
    parts.append(f"```text\n{help_text(rrf)}\n```\n")
    for name in subcommands(rrf):
        # these are answered by a second program, which a small build lacks
        if name in ("inspect", "chart", "sweep", "report"):
            continue
        parts.append(f"## rrf {name}\n\n```text\n{help_text(rrf, name)}\n```\n")
    parts.append(
        "## rrf inspect, chart, sweep, report\n\n"
        "`make report` builds the program behind these. `rrf COMMAND --help` lists their options.\n"
    )
    return "\n".join(parts)


def cell(text):
    """Text in a cell of a table, where a < would begin a tag."""
    return str(text).replace("|", "\\|").replace("\n", " ").replace("<", "&lt;")


def table_page(path):
    schema = tomllib.loads(path.read_text())
    lines = [f"## {schema['name']}\n"]
    if where := schema.get("file"):
        where = "Any file" if where == "any" else f"`{where}`"
        lines.append(f"{where}, {schema['format']}, version {schema['version']}.\n")
    if base := schema.get("extends"):
        lines.append(f"The columns of [{base}](#{base}), and those below.\n")
    lines.append(schema["doc"].strip() + "\n")
    lines += ["| column | type | unit | meaning |", "|---|---|---|---|"]
    for column in schema["column"]:
        if which := column.get("raw"):
            group = "All raw columns" if which == "all" else f"Raw columns of the {which} frame"
            lines.append(f"| *raw* | float32 | | {group}: [Inputs of the nets](inputs.md) |")
            continue
        null = ", may be null" if column.get("nullable") else ""
        kind = f"{column['type']}{null}"
        lines.append(
            f"| `{column['name']}` | {cell(kind)} | {cell(column['unit'])} | {cell(column['meaning'])} |"
        )
    return "\n".join(lines) + "\n"


def files():
    found = sorted(p.stem for p in (ROOT / "schemas").glob("*.toml") if p.stem != "inputs")
    order = [name for name in TABLES if name in found] + [n for n in found if n not in TABLES]
    head = (
        "# Files\n\n"
        "Every table that the program writes or reads, with every column. These pages follow from\n"
        "`schemas/`, which the program and the tests of the tables read as well.\n"
    )
    return "\n".join([NOTE + head] + [table_page(ROOT / f"schemas/{name}.toml") for name in order])


def inputs():
    schema = tomllib.loads((ROOT / "schemas/inputs.toml").read_text())
    lines = [
        NOTE + "# Inputs of the nets\n",
        "All that a net can read. Those without a formula are raw columns of a row; a formula names other\n"
        "inputs. A cell's net reads those of them that vary in the cell and that other inputs do not determine.\n",
        "| input | unit | meaning | formula |",
        "|---|---|---|---|",
    ]
    for one in schema["input"]:
        formula = f"`{one['formula']}`" if one.get("formula") else ""
        lines.append(f"| `{one['name']}` | {cell(one['unit'])} | {cell(one['meaning'])} | {formula} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail where a page is not up to date")
    parser.add_argument("--rrf", default=str(ROOT / "target/release/rrf"), help="the program")
    args = parser.parse_args()
    pages = {"command-line": command_line(args.rrf), "files": files(), "inputs": inputs()}
    stale = []
    for name, text in pages.items():
        path = PAGES / f"{name}.md"
        if path.exists() and path.read_text() == text:
            continue
        stale.append(str(path.relative_to(ROOT)))
        if not args.check:
            path.write_text(text)
    if args.check and stale:
        print(f"out of date: {', '.join(stale)}. Run python3 docs/generate.py", file=sys.stderr)
        return 1
    print("\n".join(stale) or "all pages are up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
