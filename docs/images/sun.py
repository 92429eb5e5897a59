#!/usr/bin/env python3
"""A furnished room under suns from morning to evening, of one bake: docs/images/salon-sun.webp.

    RRF=target/release/rrf .venv/bin/python docs/images/sun.py RUN docs/images/salon-sun.webp

RUN is a run of the salon, as `make demo` leaves it. Frames are those of `rrf view`, which
keeps the run open from one to the next; all have one exposure.
"""

import argparse
import math
import pathlib
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/runs"))
import page  # noqa: E402

FRAMES = 16
SIZE = [324, 216]
# camera rays along a side of a pixel
RAYS = 2
EXPOSURE = 1.0
# azimuth, elevation and irradiance of the sun at noon; it comes in by the window at -x
AZIMUTHS = (215, 300)
HIGHEST = 45
NOON = 6


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("run")
    parser.add_argument("picture", type=pathlib.Path)
    args = parser.parse_args()
    with page.served(args.run) as (process, address, token):
        frames = page.WebSocket(address, token, "/frames")
        frames.stream.settimeout(600)
        hello = frames.text()["hello"]
        pictures = [frame(frames, hello, k / (FRAMES - 1)) for k in range(FRAMES)]
        page.end(process)
    # there and back again
    pictures += pictures[-2:0:-1]
    first, *rest = pictures
    first.save(args.picture, save_all=True, append_images=rest, duration=110, loop=0, quality=60, method=4)
    print(f"{args.picture}: {args.picture.stat().st_size / 1e3:.0f} kB")


def frame(frames, hello, time):
    """The room at a time from 0 (morning) to 1 (evening)."""
    height = math.sin(math.pi * time)
    azimuth = AZIMUTHS[0] + time * (AZIMUTHS[1] - AZIMUTHS[0])
    # low suns are weaker and redder
    sun = [NOON * (0.25 + 0.75 * height) * (1 - share * (1 - height)) for share in (0, 0.35, 0.7)]
    sky = 0.15 + 0.85 * height
    own = [light for light in hello["own"] if light["kind"] != "distant"]
    dims = [sky if light["kind"] == "environment" else 1 for light in own]
    question = {
        **page.question(hello, SIZE),
        "aa": RAYS,
        "exposure": EXPOSURE,
        "suns": [[azimuth, 8 + (HIGHEST - 8) * height, *sun]],
        "own": [{"name": light["name"], "dim": [dim] * 3} for light, dim in zip(own, dims, strict=True)],
    }
    frames.send(question)
    facts = frames.text()
    if "error" in facts:
        raise SystemExit(facts["error"])
    return Image.frombytes("RGBA", tuple(SIZE), frames.message()).convert("RGB")


if __name__ == "__main__":
    main()
