# matrig-board.1 of what matrig-board --help prints. -v version="matrig-board 1.2.3" -v date=2026-01-31
# Before the first option: usage lines, then what the program is. Options are indented by two; two blanks end what an option is called.
function roff(text) {
    gsub(/\\/, "\\e", text)
    gsub(/-/, "\\-", text)
    return text ~ /^[.']/ ? "\\&" text : text
}
BEGIN {
    printf ".\\\" Made by hil/man.awk of matrig-board --help.\n.TH MATRIG-BOARD 1 \"%s\" \"%s\" \"User Commands\"\n", date, version
    print ".nh\n.ad l\n.SH NAME\nmatrig\\-board \\- emulated acquisition board that runs the firmware of matrig\n.SH SYNOPSIS"
    state = "usage"
}
state == "usage" && /^(usage:|      ) matrig-board/ {
    sub(/^(usage:|      ) matrig-board */, "")
    print (usages++ ? ".br\n" : "") ".B matrig\\-board\n" roff($0)
    next
}
state == "usage" { state = "text"; print ".SH DESCRIPTION" }
/^  --/ {
    if (state == "text") print ".SH OPTIONS"
    state = "options"
    sub(/^  /, "")
    if (!match($0, /  +/)) { print "man.awk: two blanks must end what an option is called: " $0 >"/dev/stderr"; failed = 1; exit 1 }
    print ".TP\n.B " roff(substr($0, 1, RSTART - 1)) "\n" roff(substr($0, RSTART + RLENGTH))
    next
}
state == "options" && /^[^ ]/ { state = "links"; print ".SH LINKS AND TIME" }
/^Exit: / { print ".SH EXIT STATUS"; sub(/^Exit: /, "") }
{ sub(/^ +/, ""); print roff($0) }
END {
    if (failed) exit 1
    print ".SH EXAMPLE\n.nf\nmatrig\\-board \\-\\-can unix:can \\-\\-serial unix:serial \\-\\-rig landing5.run &"
    print "matrig log \\-\\-can unix:can \\-\\-serial unix:serial \\-\\-db campaign.db\n.fi\n.SH SEE ALSO\n.BR matrig (1)"
}
