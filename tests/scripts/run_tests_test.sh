#!/usr/bin/env bash
# scripts/run-tests on a project of tests whose output is known: what it counts, in which order it
# prints, what it answers.
#   run_tests_test.sh SCRIPTS/RUN-TESTS
set -euo pipefail

script=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

fail() {
  echo "run_tests_test: $1" >&2
  cat out >&2
  exit 1
}
holds() { grep -qE -- "$1" out || fail "expected a line like '$1'"; }
line_of() { grep -nE -- "$1" out | tail -1 | cut -d: -f1; }

# A program of 5 tests of which 3 skip, one that skips as a whole, one that skips by its exit code,
# one that is no GoogleTest program.
cat >shard.txt <<'TEXT'
/somewhere/a_test.cpp:12: Skipped
the file aal.nii.gz is absent

/somewhere/a_test.cpp:30: Skipped
no right to mount

/somewhere/b_test.cpp:12: Skipped
the file aal.nii.gz is absent

[==========] 5 tests from 2 test suites ran. (1 ms total)
[  PASSED  ] 2 tests.
[  SKIPPED ] 3 tests.
TEXT
cat >single.txt <<'TEXT'
[ RUN      ] Data.Whole
/somewhere/a_test.cpp:12: Skipped
the file aal.nii.gz is absent

[  SKIPPED ] Data.Whole (0 ms)
[==========] 1 test from 1 test suite ran. (0 ms total)
[  PASSED  ] 0 tests.
[  SKIPPED ] 1 test, listed below:
[  SKIPPED ] Data.Whole
TEXT
cat >CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(counted LANGUAGES NONE)
enable_testing()
set(cat ${CMAKE_COMMAND} -E cat)
add_test(NAME shard COMMAND ${cat} ${PROJECT_SOURCE_DIR}/shard.txt)
add_test(NAME single COMMAND ${cat} ${PROJECT_SOURCE_DIR}/single.txt)
set_tests_properties(single PROPERTIES SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\]")
add_test(NAME plain COMMAND ${CMAKE_COMMAND} -E true)
add_test(NAME browser COMMAND sh -c "echo no browser here; exit 77")
set_tests_properties(browser PROPERTIES SKIP_RETURN_CODE 77)
if(BAD)
  add_test(NAME bad COMMAND sh -c "echo the reason; exit 1")
endif()
CMAKE
cmake -S . -B build -G Ninja >configured 2>&1 || { cat configured; exit 1; }

code=0
"$script" build -- -j 2 >out 2>&1 || code=$?
((code == 0)) || fail "expected exit code 0, found $code"
head -1 out | grep -q "^Testing build: 4 tests" || fail "expected the number of tests first"
holds '^3 tests ran in 4 entries of ctest, 5 were skipped:$'
holds '^ +3  the file aal.nii.gz is absent$'
holds '^ +1  no right to mount$'
holds '^ +1  no browser here$'
holds '^ *1/4 Test +#'
(($(line_of 'tests ran in') < $(line_of '^100% tests passed'))) ||
  fail "expected the summary before ctest's closing lines"
(($(line_of '^100% tests passed') < $(line_of '^Total Test time'))) || fail "expected them whole"
[[ $(tail -1 out) != "" ]] || fail "expected ctest's last line last"

# A second run knows what the first took.
"$script" build -- -j 2 >out 2>&1
head -1 out | grep -q "about 1 seconds as at the last run" || fail "expected a forecast"

cmake -S . -B build -DBAD=ON >configured 2>&1
code=0
"$script" build -- -j 2 >out 2>&1 || code=$?
((code == 8)) || fail "expected ctest's exit code 8, found $code"
holds '^the reason$'
holds '^4 tests ran in 5 entries'
for line in 'The following tests FAILED' '^Errors while running CTest'; do
  (($(line_of 'tests ran in') < $(line_of "$line"))) || fail "expected '$line' after the summary"
done
