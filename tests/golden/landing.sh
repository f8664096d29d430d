# Golden landings: functions for tests/cli/golden.sh and record.sh. $scratch is a folder that may be written.
golden=build/tests/golden/golden
golden_dir=${golden_dir:-tests/golden}

# newest LANDING: number of its newest version, 0: there is none
newest() { ls "$golden_dir" | sed -n "s/^landing$1\.v\([0-9]*\)\.said\.gz\$/\1/p" | sort -n | tail -n 1 | grep . || echo 0; }
# given LANDING VERSION: the file of what was given to that version: the newest that is no newer
given() {
    local v
    for ((v = $2; v > 0; v--)); do
        [ -f "$golden_dir/landing$1.v$v.given.gz" ] && echo "$golden_dir/landing$1.v$v.given.gz" && return
    done
    echo "landing $1 has no file of what was given to version $2" >&2
    return 1
}
# play LANDING ELF OUT: what this image says to what the newest version was given
play() {
    local from
    from=$(given "$1" "$(newest "$1")") && $golden replay "$from" "$scratch/$1.replay" "$scratch/$1.flash" &&
        build/matrig-board --elf "$2" --flash "$scratch/$1.flash" --replay "$scratch/$1.replay" --can "file:$scratch/$1.can" --serial "file:$scratch/$1.serial" \
            2>"$scratch/$1.board" || { cat "$scratch/$1.board"; return 1; }
    $golden said "$from" "$scratch/$1.can" "$scratch/$1.serial" "$3"
}
# new_version LANDING SAID: keep SAID beside the old ones, and ask for reasons; refuses when nothing differs
new_version() {
    local old=$(newest "$1") new file fields
    file=$golden_dir/landing$1.v$old.said.gz
    new=landing$1.v$((old + 1))
    if fields=$($golden compare --fields "$file" "$2"); then
        echo "landing $1: nothing differs from version $old; there is no new version" >&2
        return 1
    fi
    cp "$2" "$golden_dir/$new.said.gz" && echo "$fields" | sed "s/.*/$new &: /" >>"$golden_dir/CHANGES" || return 1
    echo "$golden_dir/$new.said.gz: write the reasons into $golden_dir/CHANGES"
}
# reasons_given: each version after the first has a reason in CHANGES for each field that it changed, and for no other
reasons_given() {
    local landing v base missing=0
    for landing in 1 4 5; do
        for ((v = 2; v <= $(newest "$landing"); v++)); do
            base=$golden_dir/landing$landing.v
            [ -f "$base$v.given.gz" ] && continue # given something else: nothing to compare
            $golden compare --fields "$base$((v - 1)).said.gz" "$base$v.said.gz" | sort >"$scratch/changed"
            sed -n "s/^landing$landing\.v$v \([^:]*\): *[^ ].*/\1/p" "$golden_dir/CHANGES" | sort -u >"$scratch/reasoned"
            diff "$scratch/changed" "$scratch/reasoned" >"$scratch/reasons.diff" && continue
            missing=1
            sed -n "s/^< \(.*\)/CHANGES: landing$landing.v$v changed \1: say why/p
                    s/^> \(.*\)/CHANGES: landing$landing.v$v did not change \1/p" "$scratch/reasons.diff"
        done
    done
    return $missing
}
