#!/usr/bin/env bash
# Whether two builds of gen write the same bytes, or the same values.
#
#   tests/same_bytes.sh compare REF            build REF and the working tree, run both, compare (make same-bytes REF=...)
#   tests/same_bytes.sh values REF             the same with each tree's own recipes: pixels and numbers by seed and index
#                                              are compared, ids, hashes and documents are not (make same-values REF=...)
#   tests/same_bytes.sh digest GEN DIR         run one program into DIR and write DIR/digests.txt
#   tests/same_bytes.sh datasets GEN DIR TREE  make the datasets and their sensor frames alone, from the recipes of a tree
#
# The cases: every recipe that ships, cut to a small size, seeds 0 to 2, with all images, truth maps and kept frames, and
# recipes changed so that other models, sensors and scripts have their turn; of each a validation, a report and every
# export, that of sensor frames too; light by every model through every medium; every study. QUICK=1 takes seed 0 and leaves out what is slow.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
quick=${QUICK:-0}

# A recipe at a small size with everything written: FILE -> standard output; further arguments are sed expressions.
small() {
    local file=$1 columns=192 profiles=128
    shift
    case $file in
        *thesis*) columns=96 profiles=24 ;; # whole frames go through the scripts
        *blister*) profiles=160 ;;
    esac
    sed -E \
        -e "s/^(scan: \{)columns: [0-9]+, profiles: [0-9]+/\1columns: $columns, profiles: $profiles/" \
        -e "/^scan:/,/^[a-z]+:/s/^  columns: [0-9]+/  columns: $columns/" \
        -e "/^scan:/,/^[a-z]+:/s/^  profiles: [0-9]+/  profiles: $profiles/" \
        -e '/^  sensor_stack:/d' \
        -e 's/^  (png|exr): \[.*/  \1: [range, reflectance, scatter, label, instance]/' \
        -e 's/^  truth_maps: .*/  truth_maps: true/' \
        -e 's/^output:.*/output:\n  sensor_stack: {every: 40}/' \
        "$@" "$file"
}

# Writes the cases of a tree into the current folder, with the meshes that they name.
cases() {
    local tree=$1 file
    cp -r "$tree/recipes/meshes" "$tree"/recipes/real/*.obj .
    for file in "$tree"/recipes/*.yaml "$tree"/recipes/thesis/*.yaml "$tree"/recipes/real/*.yaml; do
        local name=${file#"$tree"/recipes/}
        name=${name//\//-}
        small "$file" >"case-${name%.yaml}.yaml"
    done
    local wood=$tree/recipes/wood-small.yaml blister=$tree/recipes/blister-small.yaml
    small "$wood" -e 's/columns: 192/columns: 48/;s/profiles: 128/profiles: 4/' \
        -e 's/^subject: wood/&\ntransport: {model: path, photons_per_profile: 20000}/' >case-wood-path.yaml
    small "$wood" -e 's/columns: 192/columns: 48/;s/profiles: 128/profiles: 4/' \
        -e 's/^subject: wood/&\ntransport: diffusion/' >case-wood-diffusion.yaml
    small "$wood" -e 's/columns: 192/columns: 64/;s/profiles: 128/profiles: 6/' \
        -e 's/^subject: wood/&\ntransport: {model: thesis, method: bresenham}/' >case-wood-thesis.yaml
    small "$blister" -e 's/columns: 192/columns: 48/;s/profiles: 160/profiles: 4/' \
        -e 's/^subject: blister/&\ntransport: {model: path, photons_per_profile: 20000}/' >case-blister-path.yaml
    small "$wood" -e 's/^exposure:/&\n  bits: 12\n  hdr: medium/' -e 's/^  bin: .*/  bin: {columns: 2, profiles: 4}/' \
        >case-wood-bits.yaml
}

# Runs a command of gen, whose output and status are results too.
note() {
    local name=$1 status=0
    shift
    "$gen" "$@" >"$name.out" 2>"$name.err" || status=$?
    echo "$status" >>"$name.out"
    # Times and rates are not results.
    sed -i -E '/[0-9] s\b|\/s|min/d' "$name.err"
}

# Makes every case's datasets with a program in a new folder, and stays there.
datasets() {
    gen=$(realpath "$1")
    rm -rf "$2"
    mkdir -p "$2"
    cd "$2"
    cases "$3"
    local recipe name seed seeds="0 1 2"
    [ "$quick" = 1 ] && seeds=0
    for recipe in case-*.yaml; do
        name=${recipe#case-}
        name=${name%.yaml}
        for seed in $seeds; do
            note "$name-$seed-gen" --recipe "$recipe" --n 2 --seed "$seed" --out "$name-$seed" --samples-per-shard 2
        done
        # Frames as the real camera's files hold them; more than 8 bits are refused.
        note "$name-sensor" export icon "$name-0" --sensor --out "$name-0-sensor"
        # A case that makes no dataset would be compared with nothing on both sides.
        [ -f "$name-0/dataset.json" ] || { echo "$recipe made no dataset: $(cat "$name-0-gen.err")" >&2; exit 1; }
    done
}

digest() {
    datasets "$1" "$2" "$root"
    local recipe name
    for recipe in case-*.yaml; do
        name=${recipe#case-}
        name=${name%.yaml}
        note "$name-validate" validate "$name-0" --json
        # Which rows are exposed again is another choice each time.
        sed -i '/"rows_seed"/d' "$name-validate.out"
        note "$name-report" report "$name-0" --no-timing
        note "$name-preview" preview --recipe "$recipe" --out "$name-preview.png"
        local format
        for format in $("$gen" export --help | sed -n '/^Commands:/,/^$/s/^  \([a-z][a-z]*\) .*/\1/p' | grep -v help); do
            note "$name-$format" export "$format" "$name-0" --out "$name-export-$format"
        done
    done
    note compare-scans compare wood-small-0 wood-train-0 --json --out compare-scans.png
    note compare-packs compare blister-small-0 blister-clear-0
    note schema-recipe schema recipe
    note schema-dataset schema dataset
    note schema-reference schema recipe-reference
    local medium model
    for medium in "$root"/recipes/media/*.yaml; do
        for model in path diffusion kernel; do
            note "medium-$(basename "$medium" .yaml)-$model" transport --medium "$medium" --model "$model" --photons 20000
        done
    done
    note study-point study point --photons 20000 --out study
    note study-transport study transport --photons 20000 --out study
    note study-profile study profile --recipe case-wood-small.yaml --photons 20000 --out study
    if [ "$quick" != 1 ]; then
        local study
        for study in triangulation sensor speckle laser; do note "study-$study" study $study --repeats 2 --out study; done
        note study-packs study packs --recipe case-blister-small.yaml --out study
    fi
    find . -type f ! -name digests.txt ! -path '*/.*' -print0 | sort -z | xargs -0 sha256sum >digests.txt
    echo "$(wc -l <digests.txt) files, $(ls -d -- *-[012] | wc -l) datasets, $(cat ./*.out | wc -c) bytes printed"
}

# Builds a commit in $work/tree and the working tree: the one program becomes $work/gen-$ref.
build_both() {
    work=$root/target/same-bytes
    ref=$(git -C "$root" rev-parse --verify "$1^{commit}")
    mkdir -p "$work"
    git -C "$root" worktree prune
    [ -d "$work/tree" ] || git -C "$root" worktree add --detach "$work/tree" "$ref"
    git -C "$work/tree" checkout --quiet --detach "$ref"
    if [ ! -x "$work/gen-$ref" ]; then
        (cd "$work/tree" && cargo build --release --locked --target-dir "$work/target" --bin gen)
        cp "$work/target/release/gen" "$work/gen-$ref"
    fi
    (cd "$root" && cargo build --release --locked --workspace --bins)
}

compare() {
    local ref work
    build_both "$1"
    (digest "$work/gen-$ref" "$work/ref")
    (digest "$root/target/release/gen" "$work/new")
    if ! diff "$work/ref/digests.txt" "$work/new/digests.txt"; then
        echo "the bytes differ: the files above lie in $work/ref and $work/new" >&2
        exit 1
    fi
    echo "the same bytes as $ref"
}

values() {
    local ref work
    build_both "$1"
    (datasets "$work/gen-$ref" "$work/ref" "$work/tree")
    (datasets "$root/target/release/gen" "$work/new" "$root")
    "$root/.venv/bin/python" "$root/tests/same_values.py" "$work/ref" "$work/new"
}

"${1:?compare, values, digest or datasets}" "${@:2}"
