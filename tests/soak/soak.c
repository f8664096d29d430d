/* Soak: hours of virtual time on the emulated board, landing after landing, with random faults of
 * links, supply, clock, channels, switches and memory. What left the board is counted on its pins;
 * what the host received and declares lost by its own accounting (host/collect/loss_tracker.h) must
 * add up to it, message by message.
 *
 * soak HOURS SEED DIRECTORY
 *
 * An episode is half a minute to ten minutes from power on, with at most one landing; flash and
 * black box go on into the next. Its fault file stays in DIRECTORY when something is wrong with it.
 * Exit 0, or 1 when anything is. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "common/framing.h"
#include "hil/board/board.h"
#include "hil/rig/faults.h"
#include "host/collect/loss_tracker.h"
#include "host/collect/timebase.h"

#define ELF         "build/firmware/matrig.elf"
#define LINKS       2 /* CAN, serial: as enum link_kind */
#define COUNTS_KEPT 64u
#define PLACES      ((unsigned)MR_MESSAGE_COUNT)
#define LANDINGS    3

static const char *const link_name[LINKS] = {"CAN", "serial"};

/* Counts of messages on the pin since the board began, and as they were when each message_count
 * passed. */
struct pin {
    uint64_t left[MR_MESSAGE_COUNT];
    struct {
        uint32_t count; /* what the message_count said */
        uint64_t left;
    } kept[MR_MESSAGE_COUNT][COUNTS_KEPT];
    unsigned keep[MR_MESSAGE_COUNT];
};

struct wire {
    struct pin pin[2];                /* of the boot that goes on, of the one before */
    unsigned boot, heard_boot;        /* that goes on; that the host believes in */
    bool told[MR_MESSAGE_COUNT];      /* the host has received a count of it */
    uint32_t count[MR_MESSAGE_COUNT]; /* the last one */
    bool whole;                       /* the host heard this boot from its first frame on */
};

struct totals {
    uint64_t left[MR_MESSAGE_COUNT], received[MR_MESSAGE_COUNT], missing[MR_MESSAGE_COUNT],
        repeated[MR_MESSAGE_COUNT], dropped[MR_MESSAGE_COUNT];
};

struct soak {
    uint64_t random;
    struct hil_board *board;
    struct loss_tracker loss_tracker[LINKS];
    struct timebase time[LINKS];
    struct wire wire[LINKS];
    struct mr_deframer wire_deframer, deframer;
    uint64_t resets_seen;
    uint8_t sequence;
    uint16_t free_record[64];
    unsigned free_records;
    struct totals total[LINKS];
    uint64_t armed, refused, touchdowns, done, boots, wrong, uncounted, faults;
    uint64_t messages_after_faults[LINKS];
};

static uint32_t draw(struct soak *soak, uint32_t bound)
{
    return (uint32_t)(mr_splitmix64(&soak->random) >> 33) % bound;
}

static double between(struct soak *soak, double least, double most)
{
    return least + (most - least) * mr_splitmix64_uniform(&soak->random);
}

/* ---- accounts ---- */

/* A boot is over on a link: up to the last count that came of each message, everything is accounted
 * for. */
static void settle(struct soak *soak, unsigned link)
{
    struct wire *wire = &soak->wire[link];
    struct loss_tracker *loss_tracker = &soak->loss_tracker[link];
    struct totals *total = &soak->total[link];
    unsigned behind = wire->boot - wire->heard_boot;
    const struct pin *pin = &wire->pin[behind ? 1 : 0];
    for (unsigned place = 0; place < PLACES; place++) {
        if (!wire->told[place] || !wire->whole || behind > 1)
            continue;
        bool found = false;
        uint64_t left = 0;
        for (unsigned i = 0; i < COUNTS_KEPT && i < pin->keep[place]; i++) {
            if (pin->kept[place][i].count == wire->count[place]) {
                left = pin->kept[place][i].left;
                found = true;
            }
        }
        int64_t received = loss_tracker->received_count_at_report[place];
        int64_t missing = loss_tracker->missing_count[place],
                repeated = loss_tracker->repeated_count[place];
        total->left[place] += left;
        total->received[place] += (uint64_t)received;
        total->missing[place] += (uint64_t)missing;
        total->repeated[place] += (uint64_t)repeated;
        total->dropped[place] += wire->count[place] - left;
        if (!found || left > wire->count[place] ||
            received + missing - repeated != (int64_t)wire->count[place]) {
            printf("  %s %s: counted %" PRIu32 ", left the board %" PRIu64
                   ", received %lld, missing %lld, repeated %lld\n",
                   link_name[link], mr_message_name(place), wire->count[place], left,
                   (long long)received, (long long)missing, (long long)repeated);
            soak->wrong++;
        }
    }
    memset(loss_tracker->missing_count, 0, sizeof loss_tracker->missing_count);
    memset(loss_tracker->repeated_count, 0, sizeof loss_tracker->repeated_count);
}

static void begin_boot(struct soak *soak, unsigned link, bool whole)
{
    settle(soak, link);
    loss_tracker_restart(&soak->loss_tracker[link], whole);
    soak->time[link] = (struct timebase){0};
    memset(soak->wire[link].told, 0, sizeof soak->wire[link].told);
    soak->wire[link].whole = whole;
    soak->wire[link].heard_boot = soak->wire[link].boot;
    if (!whole)
        soak->uncounted++;
}

/* ---- what leaves the board ---- */

static void left(struct soak *soak, unsigned link, uint16_t id, const uint8_t *payload,
                 size_t length)
{
    struct pin *pin = &soak->wire[link].pin[0];
    unsigned place = mr_message_index(id);
    struct mr_message_count count;
    if (place >= PLACES)
        return;
    if (id == MR_ID_MESSAGE_COUNT && mr_message_count_get(&count, payload, length) == MR_OK) {
        unsigned of = mr_message_index(count.id);
        if (of < PLACES) {
            pin->kept[of][pin->keep[of] % COUNTS_KEPT].count = count.count;
            pin->kept[of][pin->keep[of]++ % COUNTS_KEPT].left = pin->left[of];
        }
    }
    pin->left[place]++;
}

static void watch_resets(struct soak *soak)
{
    const struct hil_counters *counters = hil_board_counters(soak->board);
    uint64_t resets = counters->resets + counters->power_cuts;
    if (resets == soak->resets_seen)
        return;
    soak->resets_seen = resets;
    soak->boots++;
    mr_deframer_init(&soak->wire_deframer);
    for (unsigned link = 0; link < LINKS; link++) {
        soak->wire[link].pin[1] = soak->wire[link].pin[0];
        memset(&soak->wire[link].pin[0], 0, sizeof soak->wire[link].pin[0]);
        soak->wire[link].boot++;
    }
}

static void can_left(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct soak *soak = ctx;
    (void)t_ps;
    watch_resets(soak);
    left(soak, LINK_CAN, (uint16_t)frame->id, frame->data, frame->length);
}

static void serial_left(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct soak *soak = ctx;
    (void)t_ps;
    watch_resets(soak);
    for (size_t i = 0; i < n; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(&soak->wire_deframer, bytes[i], &frame) == MR_OK)
            left(soak, LINK_SERIAL, frame.type, frame.payload, frame.length);
    }
}

/* ---- what the host makes of it ---- */

static void understand(struct soak *soak, unsigned link, uint16_t id, const uint8_t *payload,
                       size_t length)
{
    struct loss_tracker *loss_tracker = &soak->loss_tracker[link];
    struct mr_can_health health;
    struct mr_message_count count;
    struct mr_ack ack;
    struct mr_box_record record;
    loss_tracker_add_message(loss_tracker, mr_message_index(id));
    if (id == MR_ID_CAN_HEALTH && link == LINK_CAN &&
        mr_can_health_get(&health, payload, length) == MR_OK)
        loss_tracker_apply_can_health(loss_tracker, &health, -1);
    if (id == MR_ID_MESSAGE_COUNT && mr_message_count_get(&count, payload, length) == MR_OK) {
        unsigned place = mr_message_index(count.id);
        if (loss_tracker_apply_message_count(loss_tracker, &count) && place < PLACES) {
            soak->wire[link].told[place] = true;
            soak->wire[link].count[place] = count.count;
        }
    }
    if (link == LINK_SERIAL && id == MR_ID_ACK && mr_ack_get(&ack, payload, length) == MR_OK &&
        ack.code == MR_COMMAND_ARM)
        *(ack.status == 0 ? &soak->armed : &soak->refused) += 1;
    if (link == LINK_SERIAL && id == MR_ID_BOX_RECORD &&
        mr_box_record_get(&record, payload, length) == MR_OK && record.record &&
        soak->free_records < 64)
        soak->free_record[soak->free_records++] = record.record;
    soak->touchdowns += link == LINK_SERIAL && id == MR_ID_TOUCHDOWN;
    soak->messages_after_faults[link]++;
    loss_tracker->gap_count = 0;
}

static void can_came(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct soak *soak = ctx;
    struct mr_clock clock;
    (void)t_ps;
    if (mr_message_index((uint16_t)frame->id) >= PLACES)
        return;
    if (frame->id == MR_ID_CLOCK && mr_clock_get(&clock, frame->data, frame->length) == MR_OK &&
        clock.tick != 0 && timebase_apply_clock(&soak->time[LINK_CAN], clock.block, clock.tick)) {
        begin_boot(soak, LINK_CAN, false);
        timebase_apply_clock(&soak->time[LINK_CAN], clock.block, clock.tick);
    }
    loss_tracker_add_can_frame(&soak->loss_tracker[LINK_CAN]);
    understand(soak, LINK_CAN, (uint16_t)frame->id, frame->data, frame->length);
}

static void serial_frame_came(struct soak *soak, const struct mr_frame *frame)
{
    struct loss_tracker *loss_tracker = &soak->loss_tracker[LINK_SERIAL];
    struct mr_clock clock;
    struct mr_block block;
    bool again = false, timed = false;
    if (frame->type == MR_ID_CLOCK &&
        mr_clock_get(&clock, frame->payload, frame->length) == MR_OK && clock.tick != 0) {
        again = timebase_apply_clock(&soak->time[LINK_SERIAL], clock.block, clock.tick);
        timed = true;
    }
    if (frame->type == MR_ID_BLOCK &&
        mr_block_decode(&block, frame->payload, frame->length) == MR_OK) {
        again = timebase_apply_clock(&soak->time[LINK_SERIAL], block.index, block.tick);
        timed = true;
    }
    if (again)
        begin_boot(soak, LINK_SERIAL, false);
    else if (frame->type == MR_ID_HELLO && frame->seq == 0 && loss_tracker->seq_known &&
             loss_tracker->next_seq != 0)
        begin_boot(soak, LINK_SERIAL, true);
    loss_tracker_add_serial_frame(loss_tracker, frame->seq, -1);
    if (timed)
        loss_tracker_confirm_board_time(loss_tracker);
    understand(soak, LINK_SERIAL, frame->type, frame->payload, frame->length);
}

static void serial_came(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct soak *soak = ctx;
    (void)t_ps;
    for (size_t i = 0; i < n; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(&soak->deframer, bytes[i], &frame) == MR_OK)
            serial_frame_came(soak, &frame);
    }
}

static void command(struct soak *soak, enum mr_command_code code, int32_t argument)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX], bytes[MR_FRAME_BYTES_MAX];
    const struct mr_command message = {.code = (uint8_t)code, .tag = 9, .argument = argument};
    size_t length = mr_command_put(&message, payload);
    size_t n = mr_frame_encode(soak->sequence++, MR_ID_COMMAND, payload, length, bytes);
    (void)hil_usart_inject(&soak->board->mcu.usart, bytes, n);
}

/* ---- an episode ---- */

/* A landing that begins `later_s` later: everything before holds its first value. */
static void postpone(struct hil_run *run, double later_s)
{
    size_t more = (size_t)(later_s * run->sample_rate_hz);
    uint64_t later_ps = (uint64_t)((double)more / run->sample_rate_hz * 1e12);
    int32_t(*samples)[HIL_RUN_COLUMNS] = malloc((more + run->sample_count) * sizeof *samples);
    if (!samples)
        abort();
    for (size_t i = 0; i < more; i++)
        memcpy(samples[i], run->samples[0], sizeof samples[i]);
    memcpy(samples + more, run->samples, run->sample_count * sizeof *samples);
    free(run->samples);
    run->samples = samples;
    run->sample_count += more;
    run->duration_s += later_s;
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        if (run->switch_open_ps[i] != HIL_RUN_NEVER)
            run->switch_open_ps[i] += later_ps;
    }
    for (size_t i = 0; i < run->command_count; i++)
        run->commands[i].t_ps += later_ps;
}

static void write_fault(struct soak *soak, FILE *file, double t_s)
{
    static const char *const lines[] = {"can out", "can in", "serial out", "serial in"};
    static const char *const kinds[] = {"drop", "repeat", "corrupt", "delay"};
    static const char *const fails[] = {"stick", "high", "low", "open", "mend"};
    switch (draw(soak, 16)) {
    case 0:
    case 1:
    case 2:
    case 3:
    case 4:
    case 5: {
        const char *kind = kinds[draw(soak, 4)];
        fprintf(file, "at %.6f %s %s %u p %.3f\n", t_s, lines[draw(soak, 4)], kind,
                1 + draw(soak, 200), between(soak, 0.01, 1));
        break;
    }
    case 6:
        fprintf(file, "at %.6f bus %s\nat %.6f bus connect\n", t_s,
                draw(soak, 2) ? "unplug" : "short", t_s + between(soak, 0.01, 8));
        break;
    case 7:
        fprintf(file, "at %.6f bus dominant\nat %.6f bus connect\n", t_s,
                t_s + between(soak, 0.01, 2));
        break;
    case 8: fprintf(file, "at %.6f power-cut %u\n", t_s, 1 + draw(soak, 500)); break;
    case 9:
    case 10:
        fprintf(file, "at %.6f transducer %u %s\n", t_s, 1 + draw(soak, 8), fails[draw(soak, 5)]);
        break;
    case 11:
        fprintf(file, "at %.6f gage %u %s\n", t_s, 1 + draw(soak, 14), fails[draw(soak, 5)]);
        break;
    case 12:
        fprintf(file, "at 0.001 switch %u %s\n", 1 + draw(soak, 24),
                draw(soak, 2) ? "skip" : "bounce 3 700");
        break;
    case 13: fprintf(file, "at %.6f nor fail-program %u\n", t_s, 1 + draw(soak, 3)); break;
    case 14: fprintf(file, "at %.6f nor fail-erase %u\n", t_s, 1 + draw(soak, 3)); break;
    default:
        fprintf(file, "at %.6f reference %s\nat %.6f reference mend\n", t_s, fails[draw(soak, 4)],
                t_s + between(soak, 0.01, 3));
        break;
    }
}

static void complain(struct soak *soak, unsigned episode, const char *what)
{
    printf("  episode %u: %s\n", episode, what);
    soak->wrong++;
}

/* Virtual seconds it took. */
static double play(struct soak *soak, unsigned episode, const char *directory)
{
    static const char *const files[LANDINGS] = {
        "tests/runs/landing1.run", "tests/runs/landing4.run", "tests/runs/landing5.run"};
    char faults_path[300], flash_path[300], nor_path[300], error[300];
    struct hil_run run;
    struct hil_options options;
    struct hil_fault_script script;
    uint64_t wrong_before = soak->wrong;
    snprintf(faults_path, sizeof faults_path, "%s/episode%u.faults", directory, episode);
    snprintf(flash_path, sizeof flash_path, "%s/flash.bin", directory);
    snprintf(nor_path, sizeof nor_path, "%s/nor.bin", directory);

    if (hil_run_read(files[draw(soak, LANDINGS)], &run, error, sizeof error) != MR_OK) {
        complain(soak, episode, error);
        return 1e9;
    }
    postpone(&run, between(soak, 15, 90));
    double length_s = run.duration_s +
                      (draw(soak, 3) ? between(soak, 6, 60) : between(soak, 60, 500));
    FILE *file = fopen(faults_path, "w");
    if (!file) {
        complain(soak, episode, "cannot write its fault file");
        return 1e9;
    }
    fprintf(file, "matrig-faults 1\nseed %u\n", 1 + draw(soak, 1000000));
    unsigned faults = draw(soak, 10);
    /* Half of them in the landing; the last 12 s are left alone, so that what was lost is told. */
    for (unsigned i = 0; i < faults; i++)
        write_fault(soak, file,
                    draw(soak, 2) ? between(soak, run.duration_s - 9, run.duration_s)
                                  : between(soak, 0.01, length_s - 22));
    fprintf(file, "at %.6f bus connect\n", length_s - 12);
    fclose(file);

    hil_options_default(&options);
    options.noise_seed = 1 + draw(soak, 1000000);
    options.lsi_hz = 17000 + draw(soak, 30001);
    soak->board = hil_board_create(&options);
    struct hil_board *board = soak->board;
    const struct hil_callbacks callbacks = {
        .context = soak, .on_can_frame = can_came, .on_serial_bytes = serial_came};
    const struct hil_callbacks pin_callbacks = {
        .context = soak, .on_can_frame = can_left, .on_serial_bytes = serial_left};
    hil_board_set_callbacks(board, &callbacks);
    board->lines.pin_callbacks = pin_callbacks;
    enum mr_status status = episode ? hil_board_load_flash(board, flash_path) : MR_OK;
    if (status == MR_OK || status == MR_HALTED)
        status = hil_board_program_elf(board, ELF);
    if (status == MR_OK)
        status = hil_board_load_nor(board, nor_path);
    if (status != MR_OK)
        complain(soak, episode, hil_board_failure_reason(board));
    hil_board_attach_rig(board, &run);
    if (hil_faults_read(faults_path, ELF, &script, error, sizeof error) != MR_OK)
        complain(soak, episode, error);
    else if (hil_faults_add_all(&board->faults, &script) != MR_OK)
        complain(soak, episode, hil_board_failure_reason(board));

    soak->boots++;
    soak->resets_seen = 0;
    soak->free_records = 0;
    mr_deframer_init(&soak->wire_deframer);
    mr_deframer_init(&soak->deframer);
    for (unsigned link = 0; link < LINKS; link++) {
        memset(&soak->wire[link], 0, sizeof soak->wire[link]);
        soak->wire[link].whole = true;
        loss_tracker_start(&soak->loss_tracker[link], (enum link_kind)link);
        soak->loss_tracker[link].logged_since_start = true;
        soak->time[link] = (struct timebase){0};
    }
    uint64_t end_ps = (uint64_t)(length_s * 1e12), slice_ps = HIL_PS_PER_S;
    for (uint64_t t = slice_ps; status == MR_OK && t < end_ps + slice_ps; t += slice_ps) {
        if (t == 3 * slice_ps)
            command(soak, MR_COMMAND_BOX_LIST, 0);
        if (t >= 5 * slice_ps && soak->free_records)
            command(soak, MR_COMMAND_BOX_FREE, soak->free_record[--soak->free_records]);
        if (t + 4 * slice_ps < end_ps)
            memset(soak->messages_after_faults, 0, sizeof soak->messages_after_faults);
        status = hil_board_run_until(board, t < end_ps ? t : end_ps);
    }
    if (status != MR_OK)
        complain(soak, episode, hil_board_failure_reason(board));
    const struct hil_counters *counters = hil_board_counters(board);
    soak->faults += counters->faults_injected;
    if (counters->fault_exceptions)
        complain(soak, episode, "a processor fault");
    if (counters->watchdog_resets)
        complain(soak, episode, "the watchdog reset the board");
    for (unsigned link = 0; link < LINKS; link++) {
        if (soak->messages_after_faults[link] < 10)
            complain(soak, episode,
                     link == LINK_CAN ? "silent on CAN at the end" : "silent on serial at the end");
        settle(soak, link);
    }
    if (hil_board_save_flash(board, flash_path) != MR_OK ||
        hil_board_save_nor(board, nor_path) != MR_OK)
        complain(soak, episode, hil_board_failure_reason(board));
    hil_board_destroy(board);
    hil_run_free(&run);
    if (soak->wrong == wrong_before)
        remove(faults_path);
    else
        printf("  its faults: %s\n", faults_path);
    return length_s;
}

static void report(const struct soak *soak)
{
    printf("%-8s %-18s %12s %12s %12s %10s %10s\n", "link", "message", "left board", "received",
           "lost on link", "repeated", "no room");
    for (unsigned link = 0; link < LINKS; link++) {
        const struct totals *t = &soak->total[link];
        uint64_t sum[5] = {0};
        for (unsigned place = 0; place < PLACES; place++) {
            uint64_t lost = t->missing[place] - t->dropped[place];
            const uint64_t row[5] = {t->left[place], t->received[place], lost, t->repeated[place],
                                     t->dropped[place]};
            for (unsigned i = 0; i < 5; i++)
                sum[i] += row[i];
            if (t->left[place])
                printf("%-8s %-18s %12" PRIu64 " %12" PRIu64 " %12lld %10" PRIu64 " %10" PRIu64
                       "\n",
                       link_name[link], mr_message_name(place), row[0], row[1], (long long)row[2],
                       row[3], row[4]);
        }
        printf("%-8s %-18s %12" PRIu64 " %12" PRIu64 " %12lld %10" PRIu64 " %10" PRIu64 "\n",
               link_name[link], "all", sum[0], sum[1], (long long)sum[2], sum[3], sum[4]);
    }
}

int main(int argc, char **argv)
{
    static struct soak soak;
    double hours = argc > 1 ? atof(argv[1]) : 0.0, played_s = 0.0;
    if (argc != 4 || hours <= 0.0) {
        fprintf(stderr, "usage: soak HOURS SEED DIRECTORY\n");
        return 2;
    }
    soak.random = strtoull(argv[2], NULL, 0);
    char path[300];
    snprintf(path, sizeof path, "%s/flash.bin", argv[3]);
    remove(path);
    snprintf(path, sizeof path, "%s/nor.bin", argv[3]);
    remove(path);
    unsigned episode = 0;
    for (; played_s < hours * 3600.0; episode++) {
        played_s += play(&soak, episode, argv[3]);
        if (episode % 20 == 19) {
            fprintf(stderr, "%.0f of %.0f s, %u episodes, %" PRIu64 " wrong\n", played_s,
                    hours * 3600.0, episode + 1, soak.wrong);
            fflush(stdout);
        }
    }
    report(&soak);
    printf("%.2f h of virtual time, seed %s: %u episodes, %" PRIu64 " boots (%" PRIu64
           " not heard from the first frame on), "
           "%" PRIu64 " armed, %" PRIu64 " refused, %" PRIu64 " with a final speed; %" PRIu64
           " faults injected\n",
           played_s / 3600.0, argv[2], episode, soak.boots, soak.uncounted, soak.armed,
           soak.refused, soak.touchdowns, soak.faults);
    printf("%" PRIu64 " wrong\n", soak.wrong);
    return soak.wrong ? 1 : 0;
}
