/* What the host's side hears of a board that runs the firmware: every message, by link, decoded
 * with the catalogue. */
#ifndef MATRIG_TESTS_HIL_EAR_H
#define MATRIG_TESTS_HIL_EAR_H

#include <errno.h>

#include "common/block.h"
#include "common/canbase.h"
#include "common/catalogue.h"
#include "common/command.h"
#include "common/fault.h"
#include "common/framing.h"
#include "hil/board/board.h"
#include "hil/rig/faults.h"
#include "tests/cmocka_all.h"
#include "tests/hil/still_run.h"
#include "tests/hil/bench.h"

#define EAR_ELF     "build/firmware/matrig.elf"
#define EAR_STILL_S 200.0
#define EAR_SAID    4096

enum { EAR_CAN, EAR_SERIAL, EAR_LINKS };

/* A message that both links carry, in the order heard. */
struct ear_said {
    uint16_t id;
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
};

struct ear {
    struct hil_board *board;
    struct hil_run run;
    unsigned heard[EAR_LINKS][2048];
    uint8_t last[EAR_LINKS][2048][MR_MESSAGE_BYTES_MAX];
    uint64_t last_ps[EAR_LINKS];
    unsigned can_frames, serial_frames, serial_refused_count, serial_lost;
    uint16_t next_seq;
    bool in_step;
    struct mr_fault fault[MR_FAULT_COUNT]; /* newest report of each */
    unsigned can_sent;                     /* of the newest can_health on CAN */
    unsigned can_at_health;                /* frames heard before it */
    struct ear_said said[EAR_LINKS][EAR_SAID];
    unsigned said_count[EAR_LINKS];
    uint16_t can_base;     /* at which the board is looked for */
    bool listens;          /* keep `said` */
    struct mr_block block; /* newest record */
    unsigned blocks;
    struct mr_deframer deframer;
    char log[16384];
    FILE *log_file;
};

static inline void ear_note(struct ear *ear, unsigned link, uint64_t t_ps, uint16_t id,
                            const uint8_t *payload, size_t n)
{
    struct mr_fault fault;
    const struct mr_message_info *info = mr_message_find(id);
    if (!info || n != info->length || id >= 2048)
        return;
    ear->heard[link][id]++;
    memcpy(ear->last[link][id], payload, n);
    ear->last_ps[link] = t_ps;
    if (id == MR_ID_FAULT && mr_fault_get(&fault, payload, n) == MR_OK &&
        fault.code < MR_FAULT_COUNT)
        ear->fault[fault.code] = fault;
    if (ear->listens && ear->said_count[link] < EAR_SAID) {
        struct ear_said *said = &ear->said[link][ear->said_count[link]++];
        *said = (struct ear_said){.id = id};
        memcpy(said->payload, payload, n);
    }
}

static inline void ear_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct ear *ear = ctx;
    struct mr_can_health health;
    uint16_t id = mr_can_id_from_bus((uint16_t)frame->id, ear->can_base);
    if (id == MR_ID_CAN_HEALTH && mr_can_health_get(&health, frame->data, frame->length) == MR_OK) {
        ear->can_sent = health.sent;
        ear->can_at_health = ear->can_frames;
    }
    ear->can_frames++;
    ear_note(ear, EAR_CAN, t_ps, id, frame->data, frame->length);
}

static inline void ear_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct ear *ear = ctx;
    struct mr_frame frame;
    for (size_t i = 0; i < n; i++) {
        enum mr_status status = mr_deframer_push(&ear->deframer, bytes[i], &frame);
        if (status == MR_TOO_FEW)
            continue;
        if (status != MR_OK) {
            ear->serial_refused_count++;
            continue;
        }
        if (ear->in_step)
            ear->serial_lost += (uint16_t)(frame.seq - ear->next_seq);
        ear->in_step = true;
        ear->next_seq = (uint16_t)(frame.seq + 1u);
        ear->serial_frames++;
        if (frame.type == MR_ID_BLOCK)
            ear->blocks += mr_block_decode(&ear->block, frame.payload, frame.length) == MR_OK;
        else
            ear_note(ear, EAR_SERIAL, t_ps, frame.type, frame.payload, frame.length);
    }
}

static inline void ear_attach(struct ear *ear, struct hil_board *board)
{
    struct hil_callbacks callbacks = {ear, ear_can, ear_serial};
    ear->board = board;
    hil_board_set_callbacks(board, &callbacks);
}

static inline struct hil_options ear_options(void)
{
    struct hil_options options;
    hil_options_default(&options);
    options.has_adc_noise = false;
    options.is_jumper_fitted = true; /* configurations over CAN; test_bootrom.c leaves it out */
    return options;
}

/* A board with the firmware; `landing` 0: a rig that stands still. */
static inline struct ear *ear_open(const struct hil_options *given, unsigned landing)
{
    struct ear *ear = calloc(1, sizeof *ear);
    struct hil_options options = given ? *given : ear_options();
    char path[64], error[256];
    assert_non_null(ear);
    mr_deframer_init(&ear->deframer);
    ear->log_file = fmemopen(ear->log, sizeof ear->log - 1, "w");
    assert_non_null(ear->log_file);
    setvbuf(ear->log_file, NULL, _IONBF, 0);
    options.fault_log = ear->log_file;
    ear_attach(ear, hil_board_create(&options));
    if (hil_board_load_elf(ear->board, EAR_ELF) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(ear->board));
    snprintf(path, sizeof path, "tests/runs/landing%u.run", landing);
    if (landing && hil_run_read(path, &ear->run, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    if (!landing)
        still_run(&ear->run, EAR_STILL_S);
    hil_board_attach_rig(ear->board, &ear->run);
    return ear;
}

static inline void ear_close(struct ear *ear)
{
    hil_board_destroy(ear->board);
    hil_run_free(&ear->run);
    fclose(ear->log_file);
    free(ear);
}

static inline void ear_until(struct ear *ear, double t_s)
{
    bench_run(ear->board, (uint64_t)(t_s * 1e12 + 0.5));
}

/* Order a fault in the words of a fault file. */
static inline void ear_order(struct ear *ear, const char *line)
{
    static struct hil_fault_script script;
    char text[512], error[256];
    int n = snprintf(text, sizeof text, "matrig-faults 1\n%s\n", line);
    char name[80];
    /* programs run at the same time */
    snprintf(name, sizeof name, "%s.faults", program_invocation_short_name);
    const char *path = bench_scratch(name, text, (size_t)n);
    if (hil_faults_read(path, EAR_ELF, &script, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    if (hil_faults_add_all(&ear->board->faults, &script) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(ear->board));
}

static inline void ear_command(struct ear *ear, unsigned link, unsigned code, int32_t argument,
                               uint16_t tag)
{
    static uint16_t seq;
    struct mr_command command = {.code = (uint8_t)code, .argument = argument, .tag = tag};
    uint8_t payload[MR_MESSAGE_BYTES_MAX], bytes[MR_FRAME_BYTES_MAX];
    size_t n = mr_command_put(&command, payload);
    struct hil_can_frame frame = {.id = mr_can_id_to_bus(MR_ID_COMMAND, ear->can_base),
                                  .length = (uint8_t)n};
    memcpy(frame.data, payload, n);
    if (link == EAR_CAN)
        assert_int_equal(hil_can_inject(&ear->board->mcu.can, &frame), MR_OK);
    else
        assert_int_equal(hil_usart_inject(&ear->board->mcu.usart, bytes,
                                          mr_frame_encode(seq++, MR_ID_COMMAND, payload, n, bytes)),
                         MR_OK);
}

static inline uint32_t ear_faults(const struct ear *ear, unsigned link)
{
    struct mr_health health = {0};
    assert_int_equal(mr_health_get(&health, ear->last[link][MR_ID_HEALTH], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    return health.faults;
}

static inline struct mr_hello ear_hello(const struct ear *ear, unsigned link)
{
    struct mr_hello hello = {0};
    assert_true(ear->heard[link][MR_ID_HELLO] > 0);
    assert_int_equal(mr_hello_get(&hello, ear->last[link][MR_ID_HELLO], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    return hello;
}

static inline void ear_logged(const struct ear *ear, const char *part)
{
    if (!strstr(ear->log, part))
        fail_msg("`%s` is not in the log:\n%s", part, ear->log);
}

#define EAR_BIT(fault) (1u << MR_FAULT_##fault)

#endif
