#!/usr/bin/env bash
# matrig live and matrig log --live as processes: where they are served and to whom, what they refuse, the terminal view.
# What the page shows is tested in a browser: make test-browser.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/firmware/matrig.elf
work=$(mktemp -d /tmp/matrig.XXXXXX)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait; rm -rf "$work"' EXIT

timeout 60 build/matrig-board --elf $elf --can "unix:$work/can" --serial "unix:$work/serial" --speed real 2>"$work/board.err" &
pids+=($!)
timeout 60 build/matrig --quiet log --can "unix:$work/can" --serial "unix:$work/serial" --db "$work/x.db" --live 0 >"$work/log.out" 2>"$work/log.err" &
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
post() { # BODY LINE...
    local body=$1
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
    status_is 409 post '{"command":"arm"}' "$json" "X-Matrig-Token: $token" && grep -q 'not in this state' "$tmp/answer" || return 1
    sleep 0.2
    request "GET /state HTTP/1.1" "Host: localhost" | grep -q '"state":"armed","landing":12' || return 1
    status_is 200 post '{"command":"disarm"}' "$json" "X-Matrig-Token: $token"
}
events_go_on_where_they_were() {
    local last
    exec 7<>"/dev/tcp/127.0.0.1/$port"
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "" >&7
    : >"$tmp/first"
    for _ in $(seq 10); do # on a busy machine more than once
        timeout 1 cat <&7 >>"$tmp/first"
        grep -q '^event: state' "$tmp/first" && grep -q '^event: readings' "$tmp/first" && break
    done
    exec 7>&-
    grep -q '^event: configuration' "$tmp/first" && grep -q '^event: readings' "$tmp/first" && grep -q '^event: state' "$tmp/first" || return 1
    last=$(sed -n 's/^id: //p' "$tmp/first" | tail -n 1 | tr -d '\r')
    exec 7<>"/dev/tcp/127.0.0.1/$port"
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "Last-Event-ID: $last" "" >&7
    timeout 10 sed '/^id: /q' <&7 >"$tmp/second"
    exec 7>&-
    echo "last $last; then $(sed -n 's/^id: //p' "$tmp/second" | head -n 1)"
    ! grep -q '^retry:' "$tmp/second" && # which begins what is told anew
        [ "$(sed -n 's/^id: //p' "$tmp/second" | head -n 1 | tr -d '\r')" = "${last%-*}-$((${last#*-} + 1))" ]
}
followed_in_a_terminal() { # no terminal: lines, nothing but text
    timeout 20 build/matrig live "$work/x.db" --terminal --for 1.5 >"$tmp/lines" || return 1
    cat -v "$tmp/lines"
    [ "$(wc -l <"$tmp/lines")" -ge 1 ] && grep -Eq '^[0-9.]+ s  board alive  (idle|armed|done) 12  gear .* CAN [0-9]+ lost 0  serial [0-9]+ lost 0$' "$tmp/lines" &&
        ! grep -q $'\033' "$tmp/lines"
}
drawn_in_a_terminal() { # one of 70 columns, without colour
    script -qec "stty cols 70 rows 24; NO_COLOR=1 timeout 20 build/matrig live $work/x.db --terminal --for 0.7" /dev/null </dev/null >"$tmp/screen" || return 1
    cat -v "$tmp/screen" | head -n 40
    grep -q 'BOARD alive   LANDING' "$tmp/screen" && grep -q 'D1 .* in' "$tmp/screen" && grep -q 'T14 .* lb' "$tmp/screen" && ! grep -q $'\033\[1' "$tmp/screen"
}
advised_in_a_terminal() { # landing 5 until 2.5 s, before it warns
    played --elf $elf --can "file:$work/landing5" --serial none --rig tests/runs/landing5.run 2>/dev/null || return 1
    awk -F '[()]' '{if (!first) first = $2; if ($2 - first < 2.5) print}' "$work/landing5" >"$work/begun"
    build/matrig --quiet log --can "file:$work/begun" --db "$work/begun.db" >/dev/null 2>&1
    timeout 20 build/matrig live "$work/begun.db" --terminal --for 0.5 >"$tmp/lines" || return 1
    cat "$tmp/lines"
    tail -n 1 "$tmp/lines" | grep -Eq 'landing [0-9]+ .* advisory: the model expects a closed zone ahead before the gear stops: [0-9]+ mats, the wheel then at [0-9.]+ ft, zone ' &&
        ! grep -q WARNING "$tmp/lines" && build/matrig --json live "$work/begun.db" | grep -Eq '"says": ?"advisory"'
}
at_rest_in_a_terminal() { # landing 5 whole: the speed at the last switch, 11.9 ft/s, is none of a gear that stands
    build/matrig --quiet log --can "file:$work/landing5" --db "$work/rest.db" >/dev/null 2>&1
    timeout 20 build/matrig live "$work/rest.db" --terminal --for 0.5 >"$tmp/lines" && timeout 20 build/matrig --si live "$work/rest.db" --terminal --for 0.5 >"$tmp/si" &&
        timeout 20 build/matrig live "$work/begun.db" --terminal --for 0.5 >"$tmp/moving" || return 1
    cat "$tmp/lines" "$tmp/si" "$tmp/moving"
    tail -n 1 "$tmp/lines" | grep -Eq 'gear 90\.8 ft, at rest; touchdown 35\.49 \+- 0\.01 ft/s, 19 switches ' &&
        tail -n 1 "$tmp/si" | grep -Eq 'gear 27\.7 m, at rest; touchdown 10\.817 \+- 0\.002 m/s, 19 switches ' &&
        tail -n 1 "$tmp/moving" | grep -Eq 'gear [0-9.]+ ft, [0-9.]+ ft/s at the last switch, [0-9]+ switches'
}
state_as_json() {
    timeout 20 build/matrig --json live "$work/x.db" >"$tmp/state.json" || return 1
    head -c 300 "$tmp/state.json"
    [ "$(wc -l <"$tmp/state.json")" -eq 1 ] && grep -Eq '"state": ?"idle"' "$tmp/state.json" && grep -Eq "\"firmware\": ?\"$(build/matrig --version | cut -d' ' -f2)\"" "$tmp/state.json"
}
followers_only_watch() {
    build/matrig live "$work/x.db" --port 0 --for 20 2>"$work/follow.err" &
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
# On a serial line alone, long after the board told its channels: the log asks for them, and every reading is there. Told in turn they would
# take 8 s, and nobody would have asked.
joined_on_serial() {
    build/matrig-board --elf $elf --can none --serial "pty:$work/tty" --speed real --for 60 2>"$work/tty.err" &
    local board=$! joined i whole=$port result=1
    pids+=($board)
    await test -e "$work/tty"
    timeout 20 head -c 12000 <"$work/tty" | wc -c # what it tells at the beginning is 9 kB
    build/matrig --quiet log --serial "serial:$work/tty" --db "$work/joined.db" --live 0 >/dev/null 2>"$work/joined.err" &
    joined=$!
    pids+=($joined)
    port=$(address_in "$work/joined.err") || return 1
    port=${port#http://127.0.0.1:}
    port=${port%%/*}
    for ((i = 0; i < 200; i++)); do
        request "GET /state HTTP/1.1" "Host: localhost" | grep -o '"readings":.*"bands"' >"$tmp/readings"
        grep -q 'calibration not told yet' "$tmp/readings" && echo "told that it is not calibrated"
        [ "$(grep -o '\[-\?[0-9]' "$tmp/readings" | wc -l)" -ge 22 ] && result=0 && break
        sleep 0.05
    done
    port=$whole
    cat "$tmp/readings"
    kill -INT $joined
    wait $joined
    kill $board
    [ $result = 0 ] && [ "$(sqlite3 "$work/joined.db" "select count(*) from frames where can_id = 0x0b0 and hex(data) like '0100%'")" -ge 1 ]
}
ends_with_viewers() { # a viewer that reads nothing neither holds the log up nor its end
    exec 8<>"/dev/tcp/127.0.0.1/$port"
    printf '%s\r\n' "GET /events HTTP/1.1" "Host: localhost" "" >&8
    sleep 0.3
    kill -INT $log
    local i
    for ((i = 0; i < 50; i++)); do kill -0 $log 2>/dev/null || break; sleep 0.1; done
    exec 8>&-
    wait $log
    echo "exit $?"
    [ $i -lt 50 ] && [ "$(sqlite3 "$work/x.db" 'select sum(lost) + sum(dropped) + sum(bad) from links')" = 0 ]
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
check "a viewer that comes back goes on where it was" events_go_on_where_they_were
check "followed without a terminal: lines" followed_in_a_terminal
check "followed in a terminal without colour" drawn_in_a_terminal
check "what the predictor advises, in a terminal: an advisory, no warning" advised_in_a_terminal
check "a gear at rest has no speed" at_rest_in_a_terminal
check "followed once, as JSON" state_as_json
check "who follows a database gives no commands" followers_only_watch
check "joined on serial: every channel is asked for" joined_on_serial
check "the log loses nothing and ends with viewers that do not read" ends_with_viewers
check "a port that is taken" fails_with 3 'cannot serve the live page at .*another port' build/matrig live "$work/x.db" --port "$(
    build/matrig live "$work/x.db" --port 0 --for 3 2>"$work/taken.err" >/dev/null &
    address_in "$work/taken.err" | sed 's|.*:\([0-9]*\)/.*|\1|')"
check "no database named" fails_with 2 'DB' build/matrig live
check "a database that is not there" fails_with 3 'no such database' build/matrig live "$tmp/none.db" --port 0
check "an address of another computer's reach" fails_with 2 "0.0.0.0.*not this computer's own.*ssh -L" build/matrig live "$work/x.db" --port 0.0.0.0:8473
check "the same for log" fails_with 2 "not this computer's own" build/matrig log --can "unix:$work/none" --db "$tmp/new.db" --live 10.0.0.1:1
check "no port" fails_with 2 'no port' build/matrig live "$work/x.db" --port eighty
check "page and terminal at once" fails_with 2 'one of them' build/matrig live "$work/x.db" --terminal --port 1
check "a file that is no database" fails_with 4 'no campaign database' build/matrig live "$elf" --port 0
finish
