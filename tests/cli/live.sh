#!/usr/bin/env bash
# matrig live and matrig log --live as processes: where they are served and to whom, what they refuse.
# What the page shows is tested in a browser: make test-browser.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
work=$(mktemp -d /tmp/matrig.XXXXXX)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait; rm -rf "$work"' EXIT

timeout 600 build/matrig-board --elf $elf --can "unix:$work/can" --serial "unix:$work/serial" --speed real 2>"$work/board.err" &
pids+=($!)
timeout 600 build/matrig --quiet log --can "unix:$work/can" --serial "unix:$work/serial" --db "$work/x.db" --live 0 >"$work/log.out" 2>"$work/log.err" &
log=$!
pids+=($log)

address_in() { # FILE: what is served there, once it is
    local i
    for ((i = 0; i < 100; i++)); do
        grep -qs '^live: http://127.0.0.1:[0-9]*/#[0-9a-f]\{32\}$' "$1" && sed -n 's/^live: //p' "$1" && return 0
        sleep 0.05
    done
    return 1
}
url=$(address_in "$work/log.err")
token=${url#*#}
port=${url#http://127.0.0.1:}
port=${port%%/*}

# request LINE... : a request of these lines, as they are; the answer. Bounded by 3 s.
request() {
    exec 7<>"/dev/tcp/127.0.0.1/$port" || return 1
    printf '%s\r\n' "$@" "Connection: close" "" >&7
    timeout 3 cat <&7
    exec 7>&-
}
post() { # BODY LINE...: an order may be carried out for 5 s
    local body=${1/%\}/,\"until_us\":$((($(date +%s) + 5) * 1000000))\}}
    shift
    exec 7<>"/dev/tcp/127.0.0.1/$port" || return 1
    printf '%s\r\n' "POST /command HTTP/1.1" "Host: 127.0.0.1:$port" "Content-Length: ${#body}" "Connection: close" "$@" "" >&7
    printf '%s' "$body" >&7
    timeout 6 cat <&7
    exec 7>&-
}
status_is() { # CODE COMMAND...
    local code=$1
    shift
    "$@" | tee "$tmp/answer" | head -c 200
    head -n 1 "$tmp/answer" | grep -q "^HTTP/1.1 $code "
}

address_is_told() { [ -n "$port" ] && [ ${#token} = 32 ]; }
only_loopback() { # the kernel's own list: its port listens at 127.0.0.1, and nowhere else
    local hex
    hex=$(printf '%04X' "$port")
    awk -v p=":$hex" '$4 == "0A" && substr($2, length($2) - 4) == p {print $2}' /proc/net/tcp /proc/net/tcp6 >"$tmp/listening"
    cat "$tmp/listening"
    [ "$(cat "$tmp/listening")" = "0100007F:$hex" ]
}
page_is_served() {
    status_is 200 request "GET / HTTP/1.1" "Host: localhost:9999" && grep -q "^Content-Security-Policy: default-src 'none'" "$tmp/answer" &&
        grep -q "frame-ancestors 'none'" "$tmp/answer" && grep -q '<title>matrig live' "$tmp/answer" && ! grep -q "$token" "$tmp/answer" &&
        ! grep -Eiq '(src|href)="?(https?:)?//' "$tmp/answer"
}
plots_are_inside() {
    status_is 200 request "GET /dygraph.js HTTP/1.1" "Host: 127.0.0.1" && grep -q 'Dygraph=' "$tmp/answer" &&
        status_is 200 request "GET /licences.txt HTTP/1.1" "Host: 127.0.0.1" && grep -q 'dygraphs is MIT-licenced' "$tmp/answer"
}
other_names_are_refused() {
    local host
    for host in evil.example "evil.example:$port" 127.0.0.1.evil.example "127.0.0.1:80@evil.example" "localhost.evil.example:1" 192.168.0.1; do
        status_is 403 request "GET / HTTP/1.1" "Host: $host" || return 1
        status_is 403 request "GET /events HTTP/1.1" "Host: $host" || return 1
    done
    status_is 403 request "GET / HTTP/1.0"
}
other_requests_are_refused() {
    status_is 404 request "GET /../../etc/passwd HTTP/1.1" "Host: localhost" && status_is 404 request "GET /live.jsx HTTP/1.1" "Host: localhost" &&
        status_is 405 request "DELETE / HTTP/1.1" "Host: localhost" && status_is 405 request "POST / HTTP/1.1" "Host: localhost"
}
json="Content-Type: application/json"
commands_need_the_token() {
    status_is 403 post '{"command":"arm"}' "$json" && status_is 403 post '{"command":"arm"}' "$json" "X-Matrig-Token: ${token%?}" &&
        status_is 403 post '{"command":"arm"}' "$json" "X-Matrig-Token: $token" "Origin: http://evil.example" &&
        status_is 403 post '{"command":"arm"}' "Content-Type: text/plain" "X-Matrig-Token: $token"
}
commands_are_looked_at() {
    local body
    for body in '' '{' '[]' '{"command":"reset"}' '{"command":"arm","landing":70000}' '{"command":"arm","landing":"7"}' '{"command":"arm","landing":-1}' \
        '{"command":"disarm","landing":1}' '{"command":5}'; do
        status_is 400 post "$body" "$json" "X-Matrig-Token: $token" || return 1
    done
    status_is 413 post "$(printf '%02000d' 0)" "$json" "X-Matrig-Token: $token"
}
it_arms_and_disarms() {
    local i
    for ((i = 0; i < 100; i++)); do # not before the black box is ready
        status_is 200 post '{"command":"arm","landing":12}' "$json" "X-Matrig-Token: $token" "Origin: http://127.0.0.1:$port" && break
        sleep 0.1
    done
    grep -q '{"done":true}' "$tmp/answer" || return 1
    status_is 409 post '{"command":"arm"}' "$json" "X-Matrig-Token: $token" && grep -q 'the board is armed, in a landing' "$tmp/answer" || return 1
    sleep 0.2
    request "GET /state HTTP/1.1" "Host: localhost" | grep -q '"state_text":"armed","cause":1,"cause_text":"command","landing":12' || return 1
    status_is 409 post '{"command":"disarm","until_us":1700000000000000} ' "$json" "X-Matrig-Token: $token" && grep -q 'the time limit of the command has passed' "$tmp/answer" &&
        status_is 400 post '{"command":"disarm"} ' "$json" "X-Matrig-Token: $token" || return 1
    status_is 200 post '{"command":"disarm"}' "$json" "X-Matrig-Token: $token"
}
events_begin_with_all() {
    exec 7<>"/dev/tcp/127.0.0.1/$port"
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "" >&7
    : >"$tmp/first"
    for _ in $(seq 10); do # on a busy machine more than once
        timeout 1 cat <&7 >>"$tmp/first"
        grep -q '^event: state' "$tmp/first" && grep -q '^event: readings' "$tmp/first" && break
    done
    exec 7>&-
    grep -q '^event: configuration' "$tmp/first" && grep -q '^event: messages' "$tmp/first" && grep -q '^event: readings' "$tmp/first" && grep -q '^event: state' "$tmp/first"
}
state_as_json() {
    timeout 20 build/matrig --json live "$work/x.db" >"$tmp/state.json" || return 1
    head -c 300 "$tmp/state.json"
    [ "$(wc -l <"$tmp/state.json")" -eq 1 ] && grep -Eq '"m": ?"landing".*"state_text": ?"idle"' "$tmp/state.json" && grep -Eq '"m": ?"hello"' "$tmp/state.json"
}
followers_only_watch() {
    build/matrig live "$work/x.db" --port 0 2>"$work/follow.err" &
    local follow=$! whole other
    pids+=($follow)
    other=$(address_in "$work/follow.err") || return 1
    whole=$port
    port=${other#http://127.0.0.1:}
    port=${port%%/*}
    status_is 409 post '{"command":"arm"}' "$json" "X-Matrig-Token: ${other#*#}"
    local result=$?
    port=$whole
    kill $follow
    wait $follow
    return $result
}
# On a serial line alone: the log asks an idle board for records, and every reading is there once its channel was told, within 8 s.
joined_on_serial() {
    build/matrig-board --elf $elf --can none --serial "pty:$work/tty" --speed real --for 60 2>"$work/tty.err" &
    local board=$! joined i whole=$port result=1
    pids+=($board)
    await test -e "$work/tty"
    build/matrig --quiet log --serial "serial:$work/tty" --db "$work/joined.db" --live 0 >/dev/null 2>"$work/joined.err" &
    joined=$!
    pids+=($joined)
    port=$(address_in "$work/joined.err") || return 1
    port=${port#http://127.0.0.1:}
    port=${port%%/*}
    for ((i = 0; i < 600; i++)); do
        request "GET /state HTTP/1.1" "Host: localhost" | grep -o '"readings":.*' >"$tmp/readings"
        [ "$(grep -o '\[-\?[0-9]' "$tmp/readings" | wc -l)" -ge 22 ] && result=0 && break
        sleep 0.05
    done
    port=$whole
    cat "$tmp/readings"
    kill -INT $joined
    wait $joined
    kill $board
    return $result
}
ends_with_viewers() { # a viewer that reads nothing neither holds the log up nor its end
    exec 8<>"/dev/tcp/127.0.0.1/$port"
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "" >&8
    exec 7<>"/dev/tcp/127.0.0.1/$port" # one that reads is told how it ended
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "" >&7
    timeout 60 cat <&7 >"$tmp/events" &
    local i reader=$!
    await grep -q '^event: state' "$tmp/events"
    kill -INT $log
    for ((i = 0; i < 50; i++)); do kill -0 $log 2>/dev/null || break; sleep 0.1; done
    exec 7>&- 8>&-
    wait $log $reader
    grep -a -A 2 '^event: end' "$tmp/events" | tail -n 1
    grep -aq '^data: {"text":"Log ended normally, [0-9a-z ]*, the last is landing 12 (RUN [0-9]*)\|^data: {"text":"Log ended normally, landing 12 (RUN 1) saved"}' "$tmp/events" || return 1
    echo "exit $?"
    [ $i -lt 50 ] && [ "$(sqlite3 "$work/x.db" 'select sum(lost) + sum(dropped) + sum(bad) from links')" = 0 ]
}

outcome_is_shown() { # in the words of matrig show
    . tests/board/played.sh
    local words i follower port
    campaign_of "$work/done.db" 5 >/dev/null && words=$(build/matrig show "$work/done.db" 1 | sed -n 's/^  outcome *//p')
    [ -n "$words" ] && build/matrig --json live "$work/done.db" | grep -F "\"outcome\":true,\"notice\":\"RUN 1: $words\"" >"$tmp/notice" || return 1
    timeout 20 build/matrig live "$work/done.db" --port 0 2>"$work/done.err" &
    follower=$!
    port=$(address_in "$work/done.err" | sed 's|.*:\([0-9]*\)/.*|\1|')
    for ((i = 0; i < 10; i++)); do # a new viewer each time
        request "GET /events HTTP/1.1" "Host: localhost" >"$tmp/later"
        grep -qaF "RUN 1: $words" "$tmp/later" && break
    done
    kill $follower
    [ $i -lt 10 ]
}

check "the address is told, with a token" address_is_told
check "it is served at 127.0.0.1 and nowhere else" only_loopback
check "the page is served, with a policy that allows nothing from elsewhere, and without the token" page_is_served
check "dygraphs and its licence are in the program" plots_are_inside
check "requests to other names are refused" other_names_are_refused
check "what is not there is not served" other_requests_are_refused
check "commands need the token, the page's origin and JSON" commands_need_the_token
check "commands that make no sense are refused" commands_are_looked_at
check "arm and disarm reach the board, and its refusal comes back" it_arms_and_disarms
check "a viewer gets configuration, messages, readings, state" events_begin_with_all
check "followed once, as JSON" state_as_json
check "who follows a database gives no commands" followers_only_watch
check "the outcome of the last landing, for pages opened later too" outcome_is_shown
check "on serial alone every reading is there" joined_on_serial
check "the log loses nothing and ends with viewers that do not read" ends_with_viewers
check "a port that is taken" fails_with 3 'cannot serve the live page at .*different port' build/matrig live "$work/x.db" --port "$(
    timeout 3 build/matrig live "$work/x.db" --port 0 2>"$work/taken.err" >/dev/null &
    address_in "$work/taken.err" | sed 's|.*:\([0-9]*\)/.*|\1|')"
check "no database named" fails_with 2 'DB' build/matrig live
check "a database that is not there" fails_with 3 'no such database' build/matrig live "$tmp/none.db" --port 0
check "an address of another computer's reach" fails_with 2 "not a port: '0.0.0.0:8473'.*ssh -L" build/matrig live "$work/x.db" --port 0.0.0.0:8473
check "the same for log" fails_with 2 "not a port: '10.0.0.1:1'" build/matrig log --can "unix:$work/none" --db "$tmp/new.db" --live 10.0.0.1:1
check "no port" fails_with 2 'not a port' build/matrig live "$work/x.db" --port eighty
check "a file that is no database" fails_with 4 'not a campaign database' build/matrig live "$elf" --port 0
finish
