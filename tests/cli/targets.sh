#!/usr/bin/env bash
# CI makes or builds every target of `make help`, and says how long each part took; and the check finds what is forgotten.
. "$(dirname "$0")/tap.sh"

marked() { sed -n 's/^\([a-z0-9-]*\):.*## .* | .*/\1/p' Makefile packages.mk ./*/module.mk ./*/*/module.mk | sort; }
public() { make help | awk '/^  make /{ print $2 }' | sort; }
is_listed() { [ "$(marked | wc -l)" -gt 30 ] && diff <(marked) <(public); }

# known MAKE-OPTION...: what make knows of the targets
known() { make -npq "$@" 2>/dev/null >"$tmp/known"; [ -s "$tmp/known" ]; }
built() { python3 tests/house/targets.py "$1" $(public) <"$tmp/known"; }
is_built() { known && built .ci/run; }

# forgets PART PATTERN: a CI without that part is found
forgets() {
    known && grep -v "$1" .ci/run >"$tmp/run"
    ! built "$tmp/run" >"$tmp/forgotten"
    cat "$tmp/forgotten"
    grep -Eq "$2" "$tmp/forgotten"
}
new_target() { # that needs a program of its own
    cat >"$tmp/more.mk" <<'M'
include Makefile
wall: build/wall
	build/wall
build/wall: tests/wall.c
	cc $< -o $@
M
    known -f "$tmp/more.mk"
    ! python3 tests/house/targets.py .ci/run wall <"$tmp/known" >"$tmp/forgotten"
    cat "$tmp/forgotten"
    grep -Fxq 'wall: nothing in .ci/run builds build/wall' "$tmp/forgotten"
}

# ci FAILING: what .ci/run does where make is one that fails for FAILING, in a copy of its place
ci() {
    mkdir -p "$tmp/ci/.ci" "$tmp/ci/bin" && cp .ci/run "$tmp/ci/.ci/run"
    printf '#!/bin/sh\necho "$*" >>made\ncase " $* " in *" %s "*) exit 2 ;; esac\n' "$1" >"$tmp/ci/bin/make"
    chmod +x "$tmp/ci/bin/make"
    rm -f "$tmp/ci/made"
    PATH=$PWD/$tmp/ci/bin:$PATH bash "$tmp/ci/.ci/run" >"$tmp/ci/out" 2>&1
    local status=$?
    cat "$tmp/ci/out"
    return $status
}
tells_minutes() {
    ci nothing && [ "$(grep -Ec '^ +[0-9]+\.[0-9] min  make ' "$tmp/ci/out")" -eq "$(grep -c '^ *part make' .ci/run)" ] &&
        tail -n 1 "$tmp/ci/out" | grep -Eq '^ +[0-9]+\.[0-9] min  all$'
}
tells_what_failed() {
    ! ci test-linux && grep -Eq 'min  make test-linux: failed$' "$tmp/ci/out" && ! grep -q test-aarch64 "$tmp/ci/made" &&
        ! ci lint && grep -Eq 'min  make -j2 lint LEVELS=: failed$' "$tmp/ci/out" && ! grep -q test-clang "$tmp/ci/made"
}

check "make help lists every target that says what it does" is_listed
check "CI makes or builds each of them" is_built
check "the programs of a study that nothing builds are found" forgets build-all '^bench: nothing in .* builds .*build/tests/fit/coverage'
check "what another make builds is found too" forgets build-all '^fuzz: nothing in .* builds fuzz-programs$'
check "a target that has to be run and is not is found" forgets test-aarch64 '^test-aarch64: nothing in '
check "a new target is found" new_target
check "CI says how long each part took" tells_minutes
check "CI ends with what failed, and says which part" tells_what_failed
finish
