"""Writes cells of an extracted run as plain numbers, for programs that do not read Parquet.

    export_cells.py RUN FOLDER CELLS

CELLS cells, evenly spread over the run, become FOLDER/cell-NNNNNN.f32: little-endian float32,
row after row, 18 raw columns (px py pz nx ny nz vx vy vz lx ly lz base_r base_g base_b roughness
metallic specular) and the two half estimates (y0_r y0_g y0_b y1_r y1_g y1_b).
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

COLUMNS = (
    "px py pz nx ny nz vx vy vz lx ly lz base_r base_g base_b roughness metallic specular "
    "y0_r y0_g y0_b y1_r y1_g y1_b"
).split()


def rows_of(folder: Path) -> np.ndarray:
    """One cell's rows, float32 of shape [rows, 24]."""
    parts = [pq.ParquetFile(part).read(COLUMNS) for part in sorted(folder.glob("*.parquet"))]
    columns = [np.concatenate([part[name].to_numpy() for part in parts]) for name in COLUMNS]
    return np.stack(columns, axis=1).astype("<f4")


def main(run: str, folder: str, count: str) -> None:
    cells = sorted(Path(run, "samples").glob("cell=*"))
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    for cell in cells[:: max(1, len(cells) // int(count))][: int(count)]:
        rows_of(cell).tofile(out / f"cell-{cell.name.removeprefix('cell=')}.f32")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
