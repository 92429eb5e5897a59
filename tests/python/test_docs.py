"""The pages of docs/: links, commands and options exist, and the first steps run as they are written."""

import os
import pathlib
import re
import subprocess
import sys

import duckdb
import pyarrow.dataset as ds
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = os.environ.get("RRF", str(ROOT / "target/release/rrf"))
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("fuzz/*.md"), *ROOT.glob("scenes/*.md")])
# pages that show what older versions were called with are history
COMMANDS = [page for page in PAGES if page.name != "CHANGELOG.md" and "science" not in page.parts]
# what a bake is cut down to, so that the steps of the guide take seconds
SHORT = ["--rows", "2000", "--paths", "32", "--rounds", "1", "--cells", "4"]


def identifier(page):
    return str(page.relative_to(ROOT))


def anchors(page):
    """The anchors of a page's headings, as mdBook and GitHub make them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(), re.MULTILINE)
    clean = (re.sub(r"[^\w\- ]", "", head.lower()) for head in heads)
    return {head.strip().replace(" ", "-") for head in clean}


def blocks(page):
    """The code of a page, line by line: what is indented by four or fenced."""
    fenced = False
    for line in page.read_text().splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif fenced:
            yield line
        elif line.startswith("    "):
            yield line[4:]


def commands(page):
    """The commands of a page: lines that begin with the program, with those that go on after \\."""
    joined = "\n".join(blocks(page)).replace("\\\n", " ")
    for line in joined.splitlines():
        words = line.strip().removeprefix("target/release/")
        if re.match(r"rrf [a-z]", words):
            # two spaces part a command from what is said of it
            yield re.split(r" {2,}(?=[^ \[])", words)[0].split("  # ")[0]


@pytest.mark.parametrize("page", PAGES, ids=identifier)
def test_links_lead_somewhere(page):
    for target, _, anchor in re.findall(r"\]\(([^)#\s]*)(#([^)\s]*))?\)", page.read_text()):
        if "://" in target:
            continue
        path = (page.parent / target) if target else page
        assert path.exists(), target
        if anchor and path.suffix == ".md":
            assert anchor in anchors(path), f"{target}#{anchor}"


def test_every_page_is_in_the_summary():
    summary = (ROOT / "docs/SUMMARY.md").read_text()
    listed = {ROOT / "docs" / link for link in re.findall(r"\]\(([^)]+)\)", summary)}
    assert listed == set(ROOT.glob("docs/*/*.md"))


def test_reference_is_up_to_date():
    command = [sys.executable, ROOT / "docs/generate.py", "--check", "--rrf", BINARY]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def options():
    """The options of each subcommand, by its help."""
    known = {}

    def of(name):
        if name not in known:
            done = subprocess.run([BINARY, name, "--help"], capture_output=True, text=True)
            known[name] = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", done.stdout)) if done.returncode == 0 else None
        return known[name]

    return of


@pytest.mark.parametrize("page", COMMANDS, ids=identifier)
def test_commands_and_options_exist(page, options):
    for command in commands(page):
        for name in command.split()[1].split("|"):
            found = options(name)
            assert found is not None, command
            typed = set(re.findall(r"(?<=[ \[|])--?[a-z][\w-]*", command))
            assert typed <= found, f"{command}: {typed - found}"


def shortened(command, folder):
    """A command of the guide that takes seconds and writes below `folder`."""
    words = command.replace("512x512", "48x48").replace("480x320", "24x16").replace("--spp 256", "--spp 16").split()
    words = [re.sub(r"^out/", f"{folder}/", word) for word in words[1:]]
    words = [str(folder / word) if re.fullmatch(r"\w+\.(png|exr|html)", word) else word for word in words]
    short = (["--rows", "300"] if "transfer" in words else SHORT) if words[0] == "bake" else []
    return [BINARY, *words, *short, "--quiet"]


@pytest.fixture(scope="session")
def first(tmp_path_factory):
    """The folder that the commands of the guide's first bake have left."""
    folder = tmp_path_factory.mktemp("guide")
    ran = 0
    for command in commands(ROOT / "docs/guide/first-bake.md"):
        if command.startswith("rrf view"):
            continue  # it serves until it is stopped: test_view.py
        done = subprocess.run(shortened(command, folder), cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        ran += 1
    assert ran >= 6
    return folder


def test_the_first_bake_runs_as_written(first):
    for name in ("first/run.json", "frame.png", "frame.exr", "traced.exr"):
        assert (first / name).stat().st_size > 0, name


def test_the_tables_are_read_as_written(first, capsys):
    page = (ROOT / "docs/guide/tables.md").read_text()
    programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(programs) == 2
    for program in programs:
        exec(program.replace("out/first", str(first / "first")), {})  # noqa: S102
    assert "cell_id" in capsys.readouterr().out
    (query,) = re.findall(r"```sql\n(.*?)```", page, re.DOTALL)
    rows = duckdb.sql(query.replace("out/first", str(first / "first"))).fetchall()
    assert sum(count for _, count in rows) == ds.dataset(first / "first/samples").count_rows() > 0
