#!/bin/sh
# The small run that the notebooks look at: sh notebooks/demo.sh FOLDER, with the program in $RRF.
set -eu
cd "$(dirname "$0")/.."
folder=$1
rrf=${RRF:-target/release/rrf}
light=0.1,1.6,0.2,4,4,4
rm -rf "$folder"
mkdir -p "$folder"
"$rrf" bake scenes/cornell-box/scene.pbrt -o "$folder/run" --method nets --preset preview \
    --light-box -0.6,1.3,-0.6,0.6,1.8,0.6 --quiet
"$rrf" render "$folder/run" --light $light --size 256x256 -o "$folder/model.exr"
"$rrf" trace scenes/cornell-box/scene.pbrt --light $light --size 256x256 --spp 128 \
    -o "$folder/traced.exr" --quiet
