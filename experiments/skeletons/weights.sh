#!/usr/bin/env bash
# Fits the models that ship for automatic skeletons, to simulated scans of 24 brains at five levels, thinned by scikit-image and by willis:
#
#   willis train scikit-image willis-masks -o final.toml --model skeleton --folds 3 --save-folds
#   willis train willis-images -o images.toml --model skeleton --folds 3 --images-onto final.toml
#   willis train scikit-image -o contacts.toml --model contacts --folds 3 --save-folds
#
# and calibrates the last (calibration.sh). Beside them a model of contacts that looks at images too, which does not ship: contacts-images.toml.
#
# Argument: a folder for the cases, which is kept and gone on from (about two hours on two cores). ../skelbench.sh says what the environment names.
set -euo pipefail
work=$(mkdir -p "$1" && cd "$1" && pwd)
. "$(dirname "$0")/../skelbench.sh"
subjects=BG0002,BG0014,BG0020,BG0021,BG0022,BG06,BG07,BG12,BG13,BH0002,BH0003,BH0006,BH0008,BH0009,BH0013,BH0017,BH0019,BH0022,BH0023,BH0029,BH0030,BH0033,BH0035,Set9
for level in fine near good fair poor; do
    [ -d "$work/scikit-image/$level" ] ||
        "$python" "$bench/make_cases.py" make "$data/brava/vtp" "$work/scikit-image" --level $level --seed 1 --subjects $subjects --save-mask
done
[ -d "$work/willis-masks" ] || "$python" experiments/skeletons/own.py "$bench" "$work/scikit-image" "$work/willis-masks"
here=$PWD/experiments/skeletons
cd "$work"
"$WILLIS" train scikit-image willis-masks -o final.toml --model skeleton --folds 3 --save-folds --force
"$WILLIS" train scikit-image -o contacts.toml --model contacts --folds 3 --save-folds --force
"$here/calibration.sh" "$work" contacts.toml
images="0:0 .4:.05 .4:.1 .6:.15"
"$python" "$here/images.py" "$bench" "$data/brava/vtp" scikit-image willis-masks willis-images fair,good,poor 1 $images
"$WILLIS" train willis-images -o images.toml --model skeleton --folds 3 --images-onto final.toml --force
"$python" "$here/images.py" "$bench" "$data/brava/vtp" scikit-image scikit-image scikit-images fair,good,poor 1 $images
"$WILLIS" train scikit-images -o contacts-images.toml --model contacts --folds 3 --images-onto contacts.toml --force
