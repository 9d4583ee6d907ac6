#!/bin/sh
# Makes the corpus: a small network in every format, from the program's own writers. Needs the program (cargo build --release).
set -eu
cd "$(dirname "$0")"
willis=${WILLIS:-../target/release/willis}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat > "$work/small.swc" <<'SWC'
# a bifurcation, and a fragment beyond a gap
1 1 0 0 0 1 -1
2 1 1 0 0 1 1
3 2 2 0.5 0 0.8 2
4 2 3 1 0 0.8 3
5 3 2 -0.5 0 0.7 2
6 3 3 -1 0.25 0.7 5
7 4 3.5 1.5 0 0.6 -1
8 4 4 2 0.5 0.6 7
SWC
"$willis" candidates "$work/small.swc" -o "$work/graph.graphml" -q
put() { mkdir -p "corpus/$1"; cp "$2" "corpus/$1/$(basename "$2")"; }
# The tables of nodes and edges in one file, as the targets take them apart.
both() { mkdir -p "corpus/$1"; { cat "$2"; printf '\n====\n'; cat "$3"; } > "corpus/$1/small"; }
put swc "$work/small.swc"
put graphml "$work/graph.graphml"
put infer "$work/small.swc"
put infer "$work/graph.graphml"
endings="vtp vtk tre npz json am"
for ending in $endings; do
    "$willis" convert "$work/small.swc" "$work/small.$ending" -q
done
put vtp "$work/small.vtp"
put vtk "$work/small.vtk"
put tre "$work/small.tre"
put npz "$work/small.npz"
put markups "$work/small.json"
put amira "$work/small.am"
# An edge of two points as numbers, its thickness packed by runs.
printf '# AmiraMesh BINARY-LITTLE-ENDIAN 3.0\ndefine VERTEX 2\ndefine EDGE 1\ndefine POINT 2\nParameters { ContentType "HxSpatialGraph" }\nVERTEX { float[3] VertexCoordinates } @1\nEDGE { int[2] EdgeConnectivity } @2\nEDGE { int NumEdgePoints } @3\nPOINT { float[3] EdgePointCoordinates } @4\nPOINT { float thickness } @5(HxByteRLE,9)\n# Data section follows\n' > "$work/numbers.am"
none='\000\000\000\000'
one='\000\000\200\077'
section() { printf "@$1\n$2\n" >> "$work/numbers.am"; }
section 1 "$none$none$none$one$none$none"
section 2 "$none"'\001\000\000\000'
section 3 '\002\000\000\000'
section 4 "$none$none$none$one$none$none"
section 5 '\210'"$one$one"
put amira "$work/numbers.am"
"$willis" convert "$work/graph.graphml" "$work/edges.csv" -q
both csv "$work/nodes.csv" "$work/edges.csv"
put prior-csv "$work/edges.csv"
for format in voreen vesselvio; do
    mkdir "$work/$format"
    "$willis" convert "$work/small.swc" "$work/$format/edges.csv" --to "$format" -q
    both "$format" "$work/$format"/[nv]*.csv "$work/$format/edges.csv"
done
"$willis" convert "$work/small.swc" "$work/points.csv" --to points -q
put points "$work/points.csv"
printf 'id_a,id_b\n4,7\n' > "$work/loops.csv"
both loops "$work/small.swc" "$work/loops.csv"
printf 'node_a,node_b\n4,7\n' > "$work/links.csv"
put links "$work/links.csv"
printf 'label,x_mm,y_mm,z_mm\nR-ICA,0,0,0\nBA,1,2,3\n' > "$work/landmarks.csv"
put landmarks "$work/landmarks.csv"
printf '# CoordinateSystem = LPS\n# columns = id,x,y,z,label\n1,1,2,3,left ICA\n' > "$work/landmarks.fcsv"
put landmarks "$work/landmarks.fcsv"
printf '{"markups":[{"type":"Fiducial","coordinateSystem":"RAS","controlPoints":[{"label":"BA tip","position":[1,2,3]}]}]}' > "$work/landmarks.mrk.json"
put landmarks "$work/landmarks.mrk.json"
printf 'subject,input,spacing,inlet\na,a.swc,"0.5,0.5,1",7\n' > "$work/manifest.csv"
put manifest "$work/manifest.csv"
printf 'node,kind,value,unit\n1,pressure,100,mmHg\n8,resistance,5,mmHg s/mL\n' > "$work/conditions.csv"
put conditions-csv "$work/conditions.csv"
put weights ../crates/models/src/candidates/model/weights.toml
printf '[[condition]]\nnode = "1"\nkind = "pressure"\nvalue = 100\nunit = "mmHg"\n' > "$work/conditions.toml"
put conditions-toml "$work/conditions.toml"
printf 'Name,Type,Length,AverageRadius,StartPointPositionX,StartPointPositionY,StartPointPositionZ,EndPointPositionX,EndPointPositionY,EndPointPositionZ\nICA,1,3,1,0,0,0,3,0,0\n' > "$work/icafe.csv"
put icafe "$work/icafe.csv"
printf '\223NUMPY\001\000\166\000%-117s\n' "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1), }" > "$work/prior.npy"
printf '\000\000\000\000\000\000\360\077' >> "$work/prior.npy"
put prior-npy "$work/prior.npy"
# A NIfTI-1 mask of 4 x 2 x 2 voxels: the header's length, dimensions, type, spacing, offset and signature; then the voxels.
head -c 352 /dev/zero > "$work/mask.nii"
at() { printf "$2" | dd of="$work/mask.nii" bs=1 seek="$1" conv=notrunc status=none; }
at 0 '\134\001'
at 40 '\003\000\004\000\002\000\002\000'
at 70 '\002\000'
at 76 '\000\000\200\077\000\000\200\077\000\000\200\077\000\000\200\077'
at 108 '\000\000\260\103'
at 344 'n+1\000'
printf '\001\001\001\001\000\000\000\000\000\000\000\000\000\000\000\000' >> "$work/mask.nii"
put nifti "$work/mask.nii"
printf 'ObjectType = Image\nNDims = 3\nDimSize = 4 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n\001\001\001\001' > "$work/mask.mha"
put metaimage "$work/mask.mha"
printf 'NRRD0004\ntype: uchar\ndimension: 4\nspace: RAS\nsizes: 2 4 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\nSegment0_Layer:=1\nSegment0_LabelValue:=2\nSegment0_Name:=ICA\n\n\000\002\000\002\000\002\000\002' > "$work/mask.nrrd"
put nrrd "$work/mask.nrrd"
# A page of 4 x 1 pixels, which stand before its fields.
printf 'II\052\000\014\000\000\000\001\001\001\001\010\000' > "$work/mask.tif"
field() { printf "\\$1\\00$2\\003\\000\\001\\000\\000\\000\\$3\\000\\000\\000" >> "$work/mask.tif"; }
field 000 1 004; field 001 1 001; field 002 1 010; field 003 1 001; field 006 1 001; field 021 1 010; field 026 1 001; field 027 1 004
printf '\000\000\000\000' >> "$work/mask.tif"
put tiff "$work/mask.tif"
printf '\223NUMPY\001\000\166\000%-117s\n' "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 1, 1), }" > "$work/mask.npy"
printf '\001\001\001\001' >> "$work/mask.npy"
put npy-mask "$work/mask.npy"
# The targets that take no format: words, a name and options before a file, and bytes that networks, masks and sums are made of.
words() { mkdir -p corpus/arguments; printf '%s\n' "$@" > "corpus/arguments/$1"; }
words infer x.swc -o out -n 64 --epsilon 0.2,0.5 --max-gap 5mm --inlet 1=100mmHg --keep probable=0.3 --until stable --prior weights:auto
words simulate x.vtp -o out --outlet 2=5mmHg.s/mL@3 --stenosis "R-ICA=70%@0.5" --occlude 3 --transport --pulse typical --windkessel rc=0.69s --viscosity 3.5cP
words modulate x.csv -o out --outlets murray=700mL/min -n 100 --class "normal=0.3,0.5" --threshold 2 --save-samples
words classify x.graphml -o out --landmarks auto --labels topcow --variant-prior v.csv --unseen 0.1
words reading --units um --spacing 0.5,0.5,1 --radius effective --default-radius 0.5 --level 0.5 --radius-from inscribed --box 0,0,0,1,2,3 --frame RAS --max-input 2GiB
words phantom arterial -o x.graphml --edges 100 --break --seed 3
named() { mkdir -p corpus/front_door; { printf '%s\n%s\n' "$1" "$2"; cat "$3"; } > "corpus/front_door/$1"; }
for ending in swc $endings; do named "a.$ending" "" "$work/small.$ending"; done
named a.graphml --observed "$work/graph.graphml"
named edges.csv "" "$work/edges.csv"
named points.csv "--units um" "$work/points.csv"
named mask.nii "--radius-from distance" "$work/mask.nii"
named mask.mha "--level 0.5" "$work/mask.mha"
named mask.nrrd "" "$work/mask.nrrd"
named mask.tif "--spacing 0.5" "$work/mask.tif"
named mask.npy "--spacing 0.5" "$work/mask.npy"
gzip -9nc "$work/small.swc" > "$work/small.swc.gz"
named a.swc.gz "" "$work/small.swc.gz"
bytes() { mkdir -p "corpus/$1"; printf "$3" > "corpus/$1/$2"; }
bytes masks ring '\002\002\000\000\111\357\001'
bytes masks block '\007\007\007\043\222\377\377\377\377\377\377\377\377\377\377\360\377\377\377\377\377\377\017\377\377\377'
bytes flow series '\001\000\002\003\000\001\030\100\001\002\030\030'
bytes flow ring '\002\000\002\000\000\001\030\100\001\002\040\030\002\003\050\060\003\000\030\070'
bytes python arrays '\000\004\003\003\000\000\000\010\000\000\020\000\000\030\010\000\004\004\004\004\010\010\010\000\010\010\020\020\030'
bytes python decide '\003\011\013\002\005probable=2'
bytes python options '\004--max-gap\n5mm\n--epsilon\n0.25'
{ printf '\001'; cat "$work/mask.npy"; } > corpus/python/mask
{ printf '\002'; cat "$work/graph.graphml"; } > corpus/python/graph
# Lists and models.
printf 'edge,id_a,id_b,decision,who,when,input_sha256\n3,4,7,accept,me,2026-01-01,\n' > "$work/decisions.csv"
put decisions "$work/decisions.csv"
printf 'time_s,pressure_mmHg\n0,80\n0.1,120\n0.5,90\n0.8,80\n' > "$work/waveform.csv"
put waveform "$work/waveform.csv"
put frequencies ../crates/models/src/circle_of_willis/frequencies.csv
printf 'L-ICA I\nR-ICA I\nBA\nR-P1\nL-P1\nR-Pcom\n\nL-A1\nAcom\n' > "$work/labels"
put labels "$work/labels"
printf 'x_mm,y_mm,z_mm\n0,0,0\n' > "$work/inlets.csv"
put inlets "$work/inlets.csv"
head -c 3000 ../crates/models/src/naming/arteries.toml > "$work/names.toml"
put names "$work/names.toml"
head -c 3000 ../crates/models/src/contacts/contacts.toml > "$work/contacts.toml"
put contacts "$work/contacts.toml"
head -c 3000 ../crates/models/src/candidates/joins/skeleton.toml > "$work/joins.toml"
put joins "$work/joins.toml"
