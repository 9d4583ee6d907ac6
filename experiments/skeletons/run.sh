#!/usr/bin/env bash
# Answers to simulated scans of eight brains that no model of masks was fitted to, by what ships: whole and cropped, cut and not cut.
#
#   willis infer mask.nii.gz -o OUT [--cut never]
#   willis infer mask.nii.gz -o OUT --image IMAGE
#   willis infer fragments.npz -o OUT --box BOX [--cut always | --uncertain all | --preset paper]
#
# beside the fragments as they are, and each cycle of them cut at its thinnest vessel (simple.py); what copies of shared runs could add (passes.py), what a
# joint posterior would decide (joint.py), manual masks (manual.py), where the ends of joins lie (ends.py), how far P of contacts can be believed (contacts.py), complete circles (rings.py), tracings that nobody broke (intact.py). Then the tables of README.md and scores.png (scores.py).
#
# Argument: a folder for cases and answers, which is kept and gone on from (about half an hour on two cores). LEVELS names other levels than "good
# fair near fine poor"; good and fair are cropped too. ../skelbench.sh says what the environment names; WILLIS_GAPBENCH names the benchmark of tracings.
set -euo pipefail
work=$(mkdir -p "$1" && cd "$1" && pwd)
. "$(dirname "$0")/../skelbench.sh"
gapbench=$(realpath -m "${WILLIS_GAPBENCH:-../shared/gapbench}")
subjects=BG0003,BG08,BG11,BG18,BH0012,BH0014,BH0018,BH0024
for level in ${LEVELS:-good fair near fine poor}; do
    make=("$python" "$bench/make_cases.py" make "$data/brava/vtp" "$work/cases" --level $level --seed 2 --save-mask)
    [ -d "$work/cases/$level" ] || "${make[@]}" --subjects $subjects
    [[ $level != good && $level != fair || -d "$work/cases/$level-crop" ]] || "${make[@]}" --subjects ${subjects%,BH0018*} --crop .6
done
answer() { # name, level/subject, input, options
    local out="$work/$1/$2"
    [ -e "$out/run.json" ] || "$WILLIS" infer "$work/cases/$2/$3" -o "$out" --force --quiet --dpi 36 -n "${samples:-1}" "${@:4}"
}
for case in "$work"/cases/*/*/; do
    case=${case%/}
    case=${case#"$work"/cases/}
    box=$("$python" -c 'import json, sys; print(*sum(json.load(open(sys.argv[1]))["box_mm"], []), sep=",")' "$work/cases/$case/box.json")
    answer mask-cut "$case" mask.nii.gz
    answer mask-uncut "$case" mask.nii.gz --cut never
    answer fragments "$case" fragments.npz --box="$box"
    case $case in
    good/* | fair/*)
        answer fragments-cut "$case" fragments.npz --box="$box" --cut always
        answer uncertain-all "$case" fragments.npz --box="$box" --uncertain all
        # Only the paper decides by samples.
        samples=1000 answer paper "$case" fragments.npz --box="$box" --preset paper
        ;;
    esac
done
here=experiments/skeletons
"$python" $here/images.py "$bench" "$data/brava/vtp" "$work/cases" "$work/cases" "$work/images" good,fair 2 0:0 .4:.05 .8:.15
for image in "$work"/images/*/*/image-*.nii; do
    case=${image#"$work"/images/}
    answer "$(basename "$image" .nii)" "${case%/*}" mask.nii.gz --image "$image"
done
"$python" $here/simple.py "$work"/cases "$work"/as-is "$work"/thinnest good fair
printed() { # name, script and arguments
    [ -e "$work/$1.md" ] || { "$python" "$here/$1.py" "${@:2}" >"$work/$1.tmp" && mv "$work/$1.tmp" "$work/$1.md"; }
}
printed at_border "$work"
printed ends "$bench" "$work"
printed passes "$bench" "$work"
printed joint "$bench" "$work"
printed manual "$bench" "$data" "$work/manual"
printed contacts "$bench" "$work"
printed rings "$gapbench" "$data"
printed intact "$data"
"$python" $here/scores.py "$bench" "$work"
[ -n "$tried${LEVELS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record skeletons
