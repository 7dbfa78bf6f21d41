#!/usr/bin/env bash
# gpu-run on a software device: killed in the middle, called again, and whole; bad arguments. $1: the program gpu-run.
set -uo pipefail
gpu_run=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "FAILED: $*"; cat "$work/out/log.txt" 2>/dev/null; exit 1; }
rows() { grep -c '"status":"ok"' "$work/out/rehearsal/rows.jsonl" 2>/dev/null || true; }
keys() { grep -o '"cell":"[0-9a-f]*"' "$work/out/rehearsal/rows.jsonl" | sort; }

"$gpu_run" >/dev/null 2>&1; [[ $? == 2 ]] || fail "no arguments: expected exit code 2"
"$gpu_run" "$work/out" --config "$work/none.yaml" >/dev/null 2>&1; [[ $? == 2 ]] || fail "a configuration that is not there: expected exit code 2"
"$gpu_run" "$work/out" --budget abc >/dev/null 2>&1; [[ $? == 2 ]] || fail "a budget that is no number: expected exit code 2"

"$gpu_run" "$work/out" --budget 3000 --device software --config "$here/rehearsal.yaml" --skip-tests &
pid=$!
for ((i = 0; i < 6000; ++i)); do
  [[ $(rows) -ge 2 ]] && break
  kill -0 $pid 2>/dev/null || fail "it ended before two rows were written"
  sleep 0.1
done
kill -TERM $pid
wait $pid
code=$?
[[ $code == 143 ]] || fail "after SIGTERM: expected exit code 143, found $code"
before=$(rows)
[[ $before -ge 2 && $before -lt 9 ]] || fail "expected some of 9 rows after SIGTERM, found $before"
[[ -s $work/out/summary.md ]] || fail "expected a summary after SIGTERM"
grep -q '| cells ' "$work/out/summary.md" || fail "expected the measured cells in the summary"

"$gpu_run" "$work/out" --budget 3000 --device software --config "$here/rehearsal.yaml" --config "$here/encoding.yaml" --skip-tests ||
  fail "the second call failed"
grep -q 'Encoding with all cores' "$work/out/summary.md" || fail "expected the second configuration's table in the summary"
[[ $(grep -c '"status":"ok"' "$work/out/encoding/rows.jsonl") == 2 ]] || fail "expected the rows of encoding and of memcpy"
[[ $(rows) == 9 ]] || fail "expected 9 rows in all, found $(rows)"
[[ $(keys | uniq -d | wc -l) == 0 ]] || fail "a cell was measured twice"
grep -q 'llvmpipe' "$work/out/device.txt" || fail "expected the device by name"
echo "passed: $before rows before the end by SIGTERM, 9 after the second call"
