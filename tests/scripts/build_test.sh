#!/usr/bin/env bash
# scripts/build on a project of a few steps: what it shows, keeps and answers.
#   build_test.sh SCRIPTS/BUILD
set -euo pipefail

script=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/scripts"
cp "$script" "$work/scripts/build"
cd "$work"

fail() {
  echo "build_test: $1" >&2
  cat stderr >&2
  exit 1
}
holds() { grep -qF -- "$2" "$1" || fail "expected '$2' in $1"; }
lacks() { if grep -qF -- "$2" "$1"; then fail "expected no '$2' in $1"; fi; }

cat >CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(steps LANGUAGES NONE)
add_custom_target(good ALL COMMAND ${CMAKE_COMMAND} -E echo said-by-good
                       COMMENT "Making good")
add_custom_target(bad COMMAND ${CMAKE_COMMAND} -E echo the-reason
                      COMMAND ${CMAKE_COMMAND} -E false COMMENT "Going wrong")
CMAKE

code=0
scripts/build >stdout 2>stderr || code=$?
((code == 0)) || fail "expected exit code 0, found $code"
[[ ! -s stdout ]] || fail "expected nothing on standard output"
holds stderr "Building: 1 of 1 steps"
lacks stderr said-by-good
holds build/build.log said-by-good
holds build/build.log "Configuring done"

code=0
scripts/build good bad >stdout 2>stderr || code=$?
((code == 3)) || fail "expected exit code 3 of a target that fails, found $code"
holds stderr the-reason
holds stderr "FAILED:"
holds stderr "$work/build/build.log holds everything"
lacks stderr said-by-good
lacks stderr " -E echo"  # the command itself

# On a terminal one line moves and nothing else is printed.
if command -v script >/dev/null; then
  script -qec "scripts/build good" /dev/null </dev/null >stderr
  holds stderr $'\r'
  holds stderr "[1/1]"
  lacks stderr said-by-good
fi

echo 'message(FATAL_ERROR "no such library")' >>CMakeLists.txt
code=0
scripts/build >stdout 2>stderr || code=$?
((code == 3)) || fail "expected exit code 3 of a configuration that fails, found $code"
holds stderr "no such library"
holds stderr "Configuring failed"
