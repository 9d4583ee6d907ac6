#!/bin/sh
# Makes every file of this folder anew, with the program itself.
set -eu
cd "$(dirname "$0")/.."
cargo build --release --quiet
phantom() { target/release/willis phantom cerebral --force "$@"; }

phantom --break --seed 1 --spacing 1mm -o data/broken-circle-of-willis.swc
phantom --break --seed 2 --spacing 0.6mm -o data/scan.nii.gz

# The published circle and its ten published variants.
mkdir -p data/circle-of-willis
phantom --spacing 5mm -o data/circle-of-willis/complete.graphml
for missing in AComm L-A1 R-A1 L-P1 R-P1 L-PComm R-PComm L-PComm,R-PComm L-PComm,R-P1 R-PComm,L-P1; do
    phantom --spacing 5mm --without "$missing" -o "data/circle-of-willis/without-$(echo "$missing" | tr , -).graphml"
done

# The paper's boundary condition: every outlet at zero pressure.
{
    echo "node,kind"
    for outlet in 23 24 27 28 29 30; do echo "$outlet,ground"; done
} >data/outlets-at-ground.csv
