# Worst-case stack of the firmware from the compiler's call graph (-fcallgraph-info=su).
#
# Input: the output of nm on the ELF, then the .ci files. Interrupts nest by priority (regs.h), so the worst case is the
# deepest call chain from reset, plus one interrupt of each priority with its exception frame, plus a fault on top.
# Library functions have no figures; each counts as LIBRARY bytes, more than the largest of them pushes.
# Fails on recursion, on a call through a pointer, and when the sum exceeds the region between stack_bottom and stack_top.

BEGIN { FRAME = 108; LIBRARY = 160 } # 26 words with floating point, one more for alignment

/ stack_top$/ { top = hex($1) }
/ stack_bottom$/ { bottom = hex($1) }

/^node: / {
    title = quoted($0, "title: ")
    if (match($0, /[0-9]+ bytes \((static|dynamic,bounded|dynamic)\)/)) {
        split(substr($0, RSTART, RLENGTH), part, " ")
        own[title] = part[1]
        if ($0 ~ /\(dynamic\)/) fail("unbounded dynamic stack in " title)
    }
}
/^edge: / {
    from = quoted($0, "sourcename: ")
    to = quoted($0, "targetname: ")
    if (to == "__indirect_call") fail("call through a pointer in " from)
    calls[from] = calls[from] SUBSEP to
}

END {
    if (failed) exit 1
    total = report("thread", "start_program")
    total += FRAME + worst("supervision", "systick_irq")
    total += FRAME + worst("serial", "dma2_stream7_irq dma1_stream3_irq")
    total += FRAME + worst("CAN", "can1_tx_irq can1_rx0_irq")
    total += FRAME + worst("scan", "dma2_stream4_irq adc_irq")
    total += FRAME + worst("fault", "fault_store")
    printf "worst case %d bytes of %d\n", total, top - bottom
    for (name in library) printf "library function counted as %d bytes: %s\n", LIBRARY, name | "sort"
    close("sort")
    if (failed || total > top - bottom) { print "stack: does not fit"; exit 1 }
}

function worst(label, names,    name, i, n, deep, most) {
    n = split(names, name, " ")
    for (i = 1; i <= n; i++) {
        if (!(name[i] in own)) fail("no figures for " name[i])
        deep = depth(name[i])
        if (deep > most) most = deep
    }
    printf "%-12s %5d bytes + frame %d (%s)\n", label, most, FRAME, names
    return most
}

function report(label, name) {
    printf "%-12s %5d bytes (%s)", label, depth(name), name
    for (; name != ""; name = deepest[name]) printf " > %s", name
    printf "\n"
    return depth("start_program")
}

function depth(name,    list, n, i, deep, most) {
    if (name in known) return known[name]
    if (!(name in own)) { library[name] = 1; return known[name] = LIBRARY }
    if (name in visiting) { fail("recursion through " name); return 0 }
    visiting[name] = 1
    n = split(calls[name], list, SUBSEP)
    most = 0
    for (i = 1; i <= n; i++) {
        if (list[i] == "") continue
        deep = depth(list[i])
        if (deep > most) { most = deep; deepest[name] = list[i] }
    }
    delete visiting[name]
    return known[name] = own[name] + most
}

function quoted(line, key,    at) {
    at = index(line, key "\"")
    line = substr(line, at + length(key) + 1)
    return substr(line, 1, index(line, "\"") - 1)
}

function hex(text,    i, value) {
    for (i = 1; i <= length(text); i++) value = value * 16 + index("0123456789abcdef", tolower(substr(text, i, 1))) - 1
    return value
}

function fail(why) { print "stack: " why; failed = 1 }
