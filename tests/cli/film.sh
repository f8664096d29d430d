#!/usr/bin/env bash
# The film camera: landing 5 filmed at 100/s on the emulated board, logged, and each frame's gear position held against the run file.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/tests/variant/camera.elf
run=tests/runs/landing5.run
db=$tmp/film.db

# The camera loses two pulses in flight, one after the other later on, and jitters by 0.2 ms.
film() {
    printf 'matrig-faults 1\nat 2.5 camera skip 1\nat 3.5 camera skip 2\n' >"$tmp/camera.faults"
    played --elf $elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --rig $run --camera 100,3.3,200 \
        --faults "$tmp/camera.faults" || return 1
    build/matrig log --all --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt" || return 1
    grep ' film ' "$tmp/log.txt"
    grep -q '  film  *79[0-9] frames, 100.00 a second, 3 missing; the position of the gear is known on' "$tmp/log.txt"
}
each_pulse_once() { # from serial, which is the record
    [ "$(sqlite3 "$db" 'select count(*) from frames_film where links <> 2')" = 0 ] &&
        [ "$(sqlite3 "$db" "select count(*) from events where kind = 'camera' and code = 1 and links = 2")" = 1 ]
}
frames_are_exported() {
    build/matrig export "$db" 1 --format frames -o "$tmp/film.csv" && build/matrig --si export "$db" 1 --format frames -o "$tmp/film-si.csv" || return 1
    sed -n 4p "$tmp/film.csv" | grep -x 'frame,pulse,board_s,t_s,gear_ft,gear_error_ft,speed_ft_s,speed_error_ft_s' &&
        sed -n 4p "$tmp/film-si.csv" | grep 'gear_m,'
}
# Frame numbers are the camera's: frame n is exposed 3.3 ms + 10 (n - 1) ms after the trigger, within the jitter.
frames_have_the_cameras_numbers() {
    awk -F, '/^[0-9]/ { if (!n++) first = $3; miss = $3 - first - 0.01 * ($1 - 1); if (miss < 0) miss = -miss; if (miss > 0.00041) exit 1
        if ($1 != $2) late++ } END { print n, late; exit !(n > 790 && late > 500 && late < 640) }' "$tmp/film.csv"
}
# Truth: through the run file's exact crossings, touchdown and stop, piece by piece a cubic through four of them; before touchdown
# the speed is constant. Times of the run file and of the board differ by a constant, which the switches tell.
gear_is_where_it_is_said_to_be() {
    sqlite3 -separator ' ' "$db" 'select position, board_us from edges where position > 0' >"$tmp/edges.txt"
    awk 'BEGIN { n = 0 }
        FNR == 1 { file++ }
        file == 1 && $1 == "touchdown" { x[n] = $2; t[n++] = $3 }
        file == 1 && $1 == "truth" { truth_of[$2] = $3 }
        file == 1 && $1 == "switch" && $5 != "-" { open[$2] = $5; at[$2] = $4 }
        file == 2 { offset += open[$1] - $2 / 1e6; edges++ }
        file == 3 && !sorted++ {
            for (p = 1; p <= 24; p++) if (p in open && at[p] > x[0]) { x[n] = at[p]; t[n++] = open[p] }
            x[n] = truth_of["stop_station_ft"]; t[n++] = truth_of["stop_t_s"]; offset /= edges
        }
        file == 3 && /^[0-9]/ {
            split($0, c, ",")
            now = c[3] + offset
            if (c[5] == "") { unknown++; if (now > open[1] + 0.001) exit 1; next }
            if (now >= t[n - 1]) truth = x[n - 1]
            else if (now < t[0]) truth = x[0] - truth_of["touchdown_speed_ft_s"] * (t[0] - now)
            else {
                for (i = 0; t[i + 1] <= now; i++) ;
                i = i < 1 ? 0 : i > n - 3 ? n - 4 : i - 1
                truth = 0
                for (k = i; k < i + 4; k++) {
                    term = x[k]
                    for (m = i; m < i + 4; m++) if (m != k) term *= (now - t[m]) / (t[k] - t[m])
                    truth += term
                }
            }
            miss = c[5] - truth; if (miss < 0) miss = -miss
            seen++; inside += miss <= 1.96 * c[6]
            if (now > t[0] && now < t[n - 2]) { rolling++; squares += miss * miss; stated += c[6] * c[6] }
        }
        END { printf "%d of %d inside, %d before the first switch; rolling %d: rms %.5f ft, stated %.5f ft\n", inside, seen, unknown,
                  rolling, sqrt(squares / rolling), sqrt(stated / rolling)
              exit !(seen > 700 && unknown > 50 && inside >= 0.935 * seen && squares > stated / 9) }' \
        $run "$tmp/edges.txt" "$tmp/film.csv" | tee "$tmp/truth.txt"
    [ "${PIPESTATUS[0]}" = 0 ] && sed 's/^/# /' "$tmp/truth.txt" >&3
}
replay_gives_the_frames_again() {
    build/matrig --json --quiet replay "$db" 1 --elf $elf >"$tmp/replay.json" || { head -c 2000 "$tmp/replay.json"; return 1; }
    sqlite3 :memory: "select json_extract(value, '\$.message'), json_extract(value, '\$.compared') from json_each((select json_extract(cast(readfile('$tmp/replay.json') as text), '\$.by_message'))) where json_extract(value, '\$.message') = 'film_frame'" | tee "$tmp/compared.txt"
    [ "$(grep -c 'film_frame|[67][0-9][0-9]' "$tmp/compared.txt")" = 2 ]
}
a_bundle_keeps_the_film() {
    build/matrig bundle "$db" 1 -o "$tmp/one.db" --elf $elf && build/matrig export "$tmp/one.db" 1 --format frames | cmp - "$tmp/film.csv"
}
no_camera_no_film() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/no.can" --rig $run --camera 100 --for 3 &&
        build/matrig --quiet log --can "file:$tmp/no.can" --db "$tmp/no.db" || return 1
    ! grep -q ' 0B[89]#' "$tmp/no.can" && fails_with 2 'no film: RUN 1.*site.camera' build/matrig export "$tmp/no.db" 1 --format frames
}
cameras_are_checked() {
    for camera in 0 x 100,-1 100,1,2,3 100, 1e9; do
        fails_with 2 "camera cannot be" build/matrig-board --elf $elf --camera "$camera" || return 1
    done
    printf 'matrig-faults 1\nat 1 camera stop\n' >"$tmp/bad.faults"
    fails_with 4 'camera skip' build/matrig-board --elf $elf --for 0.1 --faults "$tmp/bad.faults"
}

exec 3>&1
check "landing 5 is filmed, and the log says how many frames" film
check "serial brings each frame, once" each_pulse_once
check "frames are exported, in feet or metres" frames_are_exported
check "frames without a pulse are counted: numbers are the camera's" frames_have_the_cameras_numbers
check "the gear is where the export says, within its stated error" gear_is_where_it_is_said_to_be
check "replay gives the frames again" replay_gives_the_frames_again
check "a bundle keeps the film" a_bundle_keeps_the_film
check "without a camera there is nothing of it" no_camera_no_film
check "cameras and their faults are checked" cameras_are_checked
check "a rig where nothing is plugged in is refused" fails_with 2 '--bare and --rig cannot be given together' build/matrig-board --bare --rig tests/runs/landing5.run
finish
