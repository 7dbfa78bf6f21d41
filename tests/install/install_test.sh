#!/usr/bin/env bash
# cmake --install into a folder that is then moved: the program works from any folder, with the data
# that lie beside it and not those of the source tree.
#   install_test.sh BUILD SOURCE
set -euo pipefail
build=$(realpath "$1")
source=$(realpath "$2")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
  echo "install_test: $1" >&2
  exit 1
}

cmake --install "$build" --prefix "$work/first" --component cvrbench >"$work/log" 2>&1 ||
  { cat "$work/log"; fail "expected an installation"; }
mv "$work/first" "$work/moved"
root=$work/moved
data=$root/share/cvrbench
for path in bin/cvrbench share/cvrbench/{configs/quick.yaml,configs/scenes/cells.yaml} \
  share/cvrbench/{results/published/csgvr.yaml,results/schema/row.schema.json,plots/report.py}; do
  [[ -f $root/$path ]] || fail "expected $path"
done
if grep -rlF "$source" "$data" >&2; then fail "expected no path of the source tree"; fi

# What only this installation has.
cat >"$data/configs/datasets/moved.yaml" <<'YAML'
cells_of_the_moved:
  title: "Cells"
  licence: MIT
  kind: labels
  type: u16
  extent: [32, 28, 24]
  generator: cells
  seed: 3
  parameters: {}
YAML
sed 's/^title:.*/title: "Moved"/' "$data/configs/scenes/cells.yaml" >"$data/configs/scenes/of_the_moved.yaml"
sed -i 's|</body>|<!-- of the moved --></body>|' "$data/plots/template.html.j2"
grep -q "of the moved" "$data/plots/template.html.j2" || fail "expected a body in the template"

mkdir "$work/elsewhere"
cd "$work/elsewhere"
cat >small.yaml <<'YAML'
title: "An installation"
rounds: 1
max_rounds: 1
timeout_s: 300
matrix:
  - datasets: [cells_of_the_moved]
    codecs: [raw, csgvr-sb]
    stages: [encode, decode]
  - datasets: [cells_of_the_moved]
    codecs: [csgvr-sb]
    stages: [render]
    scenes: [of_the_moved]
    access_modes: [none]
    size: [32, 18]
    frames: 1
tables:
  - name: rates
    title: "Rates"
    rows: [codec]
    columns: [rate]
YAML
cvrbench=$root/bin/cvrbench
"$cvrbench" list datasets | grep cells_of_the_moved >/dev/null || fail "expected list to know the data set"
"$cvrbench" plan small.yaml >plan 2>&1 || { cat plan; fail "expected a plan"; }
"$cvrbench" run small.yaml --out o >run 2>&1 || { cat run; fail "expected a run"; }
(($(grep -c '"status":"ok"' o/rows.jsonl) == 7)) || { cat run; fail "expected seven rows that are ok"; }
"$cvrbench" report --results o -o page.html --store none >report 2>&1 ||
  { cat report; fail "expected a report"; }
grep -q "of the moved" page.html || fail "expected the page of the installed report"
"$cvrbench" pack o -o o.zip >pack 2>&1 || { cat pack; fail "expected a pack"; }
"$cvrbench" verify o.zip --cells 1 >verify 2>&1 || { cat verify; fail "expected the pack to verify"; }
"$cvrbench" leaderboard o o.zip -o site >site.log 2>&1 || { cat site.log; fail "expected a site"; }
