# Public targets by group, from lines `target: ... ## group | text` of the makefiles.
/^[a-z0-9-]+:.*## .* \| / {
    target = $0
    sub(/:.*/, "", target)
    text = $0
    sub(/.*## /, "", text)
    group = text
    sub(/ \| .*/, "", group)
    sub(/[^|]* \| /, "", text)
    lines[group] = lines[group] sprintf("  make %-17s %s\n", target, text)
}
END {
    count = split("every day,tests,studies,longer", groups, ",")
    for (i = 1; i <= count; i++) {
        printf("%s%s:\n%s", (i > 1 ? "\n" : ""), groups[i], lines[groups[i]])
        delete lines[groups[i]]
    }
    for (group in lines) {
        printf "a group that no heading is for: %s\n", group
        exit 1
    }
}
