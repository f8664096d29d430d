# From the firmware's register header: what tests/hil/test_layouts.c compares with registers.txt.
#     LVALUE(NAME)  a register by itself     NUMBER(NAME)  an address, bits or a value     MACRO(NAME)  with an argument
#     FIELD(struct, register)                IRQ(NAME)
function trim(text) { gsub(/[ \t]/, "", text); return text }
/^#define [A-Z0-9_]+_H$/ { next }
/^#define [A-Z0-9_]+\(/ { name = $2; sub(/\(.*/, "", name); print "MACRO(" name ")"; next }
/^#define [A-Z0-9_]+ +\(\*/ { print "LVALUE(" $2 ")"; next }
/^#define [A-Z0-9_]+ / { print "NUMBER(" $2 ")"; next }
/^struct / { of = $2; next }
/^};/ { of = "" }
of && /^    reg32 / {
    line = $0
    while (line !~ /;/ && (getline more) > 0)
        line = line more
    sub(/^    reg32 /, "", line)
    sub(/;.*/, "", line)
    n = split(line, names, ",")
    for (i = 1; i <= n; i++) {
        name = trim(names[i])
        sub(/\[.*/, "", name)
        if (name !~ /^reserved/)
            print "FIELD(" of ", " name ")"
    }
}
/^    IRQ_[A-Z0-9_]+ = / { print "IRQ(" $1 ")" }
