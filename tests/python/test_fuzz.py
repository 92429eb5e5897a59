"""The inputs that fuzzing kept, read once more: no panic, none slow, none that takes much memory."""

import os
import pathlib
import re
import subprocess
import zipfile

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = pathlib.Path(os.environ.get("RRF_EXAMPLES", ROOT / "target/release/examples"))
KEPT = sorted((ROOT / "fuzz/kept").glob("*.zip"))


@pytest.mark.parametrize("archive", KEPT, ids=lambda path: path.stem)
def test_kept_inputs_are_read_or_refused(archive, tmp_path):
    with zipfile.ZipFile(archive) as kept:
        kept.extractall(tmp_path)
        count = len(kept.namelist())
    done = subprocess.run([EXAMPLES / "mutate", archive.stem, "--replay", tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = re.fullmatch(r"\w+: (\d+) inputs, slowest [\d.]+ s, at most (\d+) MiB resident\n", done.stdout)
    assert told and int(told[1]) == count > 100 and int(told[2]) < 256, done.stdout
