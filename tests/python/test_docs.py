"""The pages of docs/: links, commands and options exist, and the first steps run as they are written."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import duckdb
import numpy as np
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = os.environ.get("RRF", str(ROOT / "target/release/rrf"))
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("fuzz/*.md"), *ROOT.glob("scenes/*.md")])
# pages that show what older versions were called with are history
COMMANDS = [page for page in PAGES if page.name != "CHANGELOG.md" and "science" not in page.parts]
# what bakes are cut down to, so that the steps of the guide take seconds; what is asked for is not what is tried here
SHORT = {"nets": ["--rows", "2000", "--paths", "32", "--rounds", "1", "--cells", "4"], "transfer": ["--rows", "300"]}


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


@pytest.mark.parametrize("page", PAGES, ids=identifier)
def test_no_text_is_taken_for_a_tag(page):
    """Outside of code a < followed by a letter is HTML, and swallows what follows."""
    text = re.sub(r"```.*?```|`[^`\n]*`|<!--.*?-->", "", page.read_text(), flags=re.DOTALL)
    lines = [line for line in text.splitlines() if not line.startswith("    ")]
    assert re.findall(r"<[A-Za-z][^>]*>", "\n".join(lines)) == []


# pages whose words are the program's own, or history
GENERATED = ["command-line", "files", "inputs"]
PROSE = [ROOT / "README.md", *(p for p in sorted(ROOT.glob("docs/*/*.md")) if p.stem not in GENERATED)]


def sentences(text):
    """The sentences of a page's paragraphs and lists, as words; code, tables and headings left out."""
    kept, fenced = [], False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        if fenced or re.match(r" {4}\S|[|#!]|```|<!--", line):
            kept.append("")
        else:
            item = re.match(r"([-*]|\d+\.) ", line)
            kept += ["", line[item.end() :]] if item else [line]
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", "\n".join(kept))
    text = re.sub(r"`[^`]*`", "CODE", text)
    # an abbreviation ends a sentence only where another begins
    text = re.sub(r"et al\.(?! [A-Z])", "et al", text)
    # what closes a sentence may stand in bold or in brackets; a colon closes one if a new one begins
    end = r"(?<=[.:?!])[*)”]*\s+(?=[A-Z*\d(\u0370-\u03ff])|(?<=[.:?!])[*)”]+\s+"
    for paragraph in re.split(r"\n\s*\n", text):
        for sentence in re.split(end, paragraph):
            if words := [word for word in sentence.split() if re.search(r"\w", word)]:
                yield words


def test_sentences_are_found():
    text = "# A head\n\nOne is\nhere. 2 more (as et al. say). **Bold.** Then `x. Y`: end\n\n    code. Code\n\n- item one\n- item\n  two\n\n| a. B |"
    found = [" ".join(words) for words in sentences(text)]
    assert found == ["One is here.", "2 more (as et al say).", "**Bold.", "Then CODE: end", "item one", "item two"]


@pytest.mark.parametrize("page", PROSE, ids=identifier)
def test_sentences_are_short(page):
    found = list(sentences(page.read_text()))
    assert [" ".join(words) for words in found if len(words) > 25] == []
    assert sum(map(len, found)) <= 15 * len(found)


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= 100


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
    short = SHORT["nets" if "nets" in words else "transfer"] if words[0] == "bake" else []
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
    for name in ("first/run.json", "nets/run.json", "room/run.json", "frame.png", "frame.exr", "traced.exr"):
        assert (first / name).stat().st_size > 0, name


def test_the_tables_are_read_as_written(first, capsys):
    page = (ROOT / "docs/guide/tables.md").read_text()
    programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(programs) == 2
    for program in programs:
        exec(program.replace("out/", f"{first}/"), {})  # noqa: S102
    assert "cell_id" in capsys.readouterr().out
    subprocess.run([BINARY, "export", first / "first", "--parquet", first / "tables"], check=True)
    samples, cells = re.findall(r"```sql\n(.*?)```", page, re.DOTALL)
    rows = duckdb.sql(samples.replace("out/", f"{first}/")).fetchall()
    assert sum(count for _, count in rows) == ds.dataset(first / "nets/samples").count_rows() > 0
    assert duckdb.sql(cells.replace("out/tables", str(first / "tables"))).fetchall()


# commands that other tests run as they are: the page, batches, object stores, the report's program
ELSEWHERE = re.compile(r"rrf (view|run|inspect|report|chart|sweep)\b|s3://")


def points_table(file):
    """Two points of the Cornell box's floor, seen from above and lit from the middle."""
    one = dict(zip("px py pz nx ny nz vx vy vz lx ly lz".split(), (0.1, 0, 0.8, 0, 1, 0, 0, 1, 0, 0, 1.5, 0), strict=True))
    pq.write_table(pa.table({name: np.full(2, value, np.float32) for name, value in one.items()}), file)


def filled(command, folder):
    """A command with files in place of its placeholders, at a size that takes seconds."""
    scene, run = ROOT / "scenes/cornell-box/scene.pbrt", folder / "first"
    bakes = re.search(r"\brrf (bake|plan SCENE)", command)
    command = re.sub(r"\[[^\]]*\]", "", command.split("     ")[0])
    places = {
        "SCENE": scene, "room.glb": ROOT / "scenes/salon/salon.glb", "sky.exr": ROOT / "scenes/salon/sky.exr",
        "RUN": folder / "new" if bakes else run, "P": folder / "points.parquet", "points.parquet": folder / "points.parquet",
        "A.exr": folder / "frame.exr", "B.exr": folder / "traced.exr", "camera.csv": folder / "camera.csv",
        "OUT": folder / "out.parquet", "F": folder / "nets.onnx", "F.exr": folder / "F.exr", "FRAMES": folder / "frames",
        "x0,y0,z0,x1,y1,z1": "-1,0.5,-1,1,2,1", "out/room": folder / ("baked" if bakes else "room"), "out/first": run, "out/tables": folder / "copies", "DIR": folder / "copies",
    }
    words = command.split()[1:]
    words = [str(places.get(word, word)) for word in words]
    words = [str(folder / word) if re.fullmatch(r"\w+\.(png|exr|parquet|safetensors)", word) else word for word in words]
    words = ["16" if before == "--spp" else "24x16" if before == "--size" else word for before, word in zip(["", *words], words)]
    if words[0] in ("render", "trace") and "--size" not in words and "--points" not in words:
        words += ["--size", "24x16"]
    if bakes:
        words += SHORT["nets" if "nets" in words else "transfer"]
    return [BINARY, "--quiet", *words]


@pytest.mark.parametrize("page", ["README.md", *(f"docs/guide/{name}.md" for name in ("frames", "lights", "mirrors-and-glass", "own-scene", "tables", "batch", "install"))])
def test_the_commands_of_a_page_run(page, first):
    """In their order, cut down; what a command needs has been left by the first bake."""
    points_table(first / "points.parquet")
    (first / "camera.csv").write_text("eye_x,eye_y,eye_z,target_x,target_y,target_z,fov\n0,1,3,0,1,0,40\n0,1,2.9,0,1,0,40\n")
    ran = 0
    for command in commands(ROOT / page):
        if ELSEWHERE.search(command):
            continue
        for old in ("new", "baked"):
            shutil.rmtree(first / old, ignore_errors=True)
        # frames of a path make a folder of their own
        shutil.rmtree(first / "frames", ignore_errors=True)
        done = subprocess.run(filled(command, first), cwd=ROOT, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        ran += 1
    assert ran


def test_the_tasks_of_a_bake_run_one_by_one(tmp_path):
    """The four commands of the page, with the tasks of a round between the second and the third."""
    plan, task, missing, commit = commands(ROOT / "docs/reference/tasks.md")
    folder = tmp_path / "run"

    def run(command, *more):
        scene = ROOT / "scenes/cornell-box/scene.pbrt"
        words = command.replace("[settings]", "").replace("SCENE", str(scene)).replace("RUN", str(folder)).split("  ")[0]
        done = subprocess.run([BINARY, *words.split()[1:], *more], capture_output=True, text=True)
        assert done.returncode == 0, f"{command}: {done.stderr}"
        return done.stdout

    run(plan, *SHORT["nets"], "--light-box=-0.6,1.3,-0.6,0.6,1.8,0.6")
    while left := re.findall(r"^\d+$", run(missing), re.MULTILINE):
        run(re.sub(r"--index \d+", f"--index {left[0]}", task))
    run(commit)
    assert (folder / "model/weights.arrow").stat().st_size > 0
