#!/bin/sh
# Makes every file of this folder anew, with the program itself.
set -eu
cd "$(dirname "$0")/.."
cargo run --release --quiet -- phantom cerebral --break --seed 1 --spacing 1mm --force -o data/broken-circle-of-willis.swc
