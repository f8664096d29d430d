#include "hil/board/board.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unicorn/unicorn.h>
#include <unistd.h>

#include "common/image.h"
#include "hil/core/cpu.h"
#include "hil/core/core.h"
#include "hil/core/elf.h"
#include "hil/core/nvic.h"
#include "hil/periph/options.h"

/* ---- connections: the chip's pins to the rig, its buses to the links ---- */

static void connect_core(struct hil_board *board)
{
    struct hil_core *core = &board->core;
    core->memory = &board->memories->mcu;
    core->has_no_ccm = board->options.type->has_no_ccm;
    core->is_alignment_checked = board->options.is_alignment_checked;
    core->instruction_cycle_parts =
        (uint32_t)(board->options.cycles_per_instruction * HIL_PARTS_PER_CYCLE + 0.5);
    hil_core_create(core);
    hil_systick_create(core);
    hil_clock_start(&core->state.clock, 16000000);
}

/* Pin changes are reported to the parts in this order: rig, chip, camera. */
static void connect_pins(struct hil_board *board)
{
    struct hil_core *core = &board->core;
    struct hil_mcu *mcu = &board->mcu;
    board->rig.core = board->camera.core = core;
    board->rig.state = &board->state.rig;
    board->rig.has_no_rig = board->options.has_no_rig;
    board->rig.gpio = board->camera.gpio = &mcu->gpio;
    board->rig.adc = &mcu->adc;
    board->rig.type = board->options.type;
    board->rig.electronics = &board->electronics;
    board->camera.options = &board->options;
    board->camera.state = &board->state.camera;
    for (unsigned i = 0; i < HIL_BOARD_PULL_COUNT; i++) {
        const struct hil_pull *pull = &board->options.type->pulls[i];
        hil_gpio_add_pull(&mcu->gpio, pull->location.port, pull->location.pin, pull->is_up);
    }
    hil_rig_create(&board->rig);
    hil_mcu_create(mcu, core, &board->options, &board->state.mcu);
    hil_camera_create(&board->camera);
}

static void connect_chips(struct hil_board *board)
{
    const struct hil_options *options = &board->options;
    board->w25q = (struct hil_w25q_device){
        .core = &board->core,
        .options = options,
        .state = &board->state.w25q,
        .fault_requests = &board->state.nor_fault_requests,
        .rules = &board->mcu.rules,
        .spi = &board->mcu.spi,
        .inverted_cells = board->memories->nor,
        .on_operation_begin = {hil_faults_on_nor_operation, &board->faults},
    };
    board->tmp112 = (struct hil_tmp112_device){
        .core = &board->core, .options = options, .state = &board->state.tmp112};
    board->mcu.spi.slave = hil_w25q_slave(&board->w25q);
    board->mcu.i2c.slave = hil_tmp112_slave(&board->tmp112);
    board->mcu.flash.on_operation_begin = (struct hil_callback){hil_faults_on_flash_operation,
                                                                &board->faults};
    hil_flash_create(&board->mcu.flash);
    hil_w25q_create(&board->w25q);
    board->supply = (struct hil_supply_device){
        .core = &board->core,
        .state = &board->state.supply,
        .flash = &board->mcu.flash,
        .rcc = &board->mcu.rcc,
        .nor = &board->w25q,
        .thermometer = &board->tmp112,
    };
    hil_supply_create(&board->supply);
}

static void connect_links(struct hil_board *board)
{
    board->lines = (struct hil_lines_device){
        .core = &board->core,
        .options = &board->options,
        .state = &board->state.lines,
        .on_frame_sent = {hil_faults_on_can_sent, &board->faults},
    };
    hil_lines_init(&board->lines, board->options.noise_seed);
    board->mcu.can.line_calls = board->mcu.usart.line_calls = hil_lines_calls(&board->lines);
}

static void connect_run_inputs(struct hil_board *board)
{
    struct hil_mcu *mcu = &board->mcu;
    board->script = (struct hil_command_script_device){
        .core = &board->core,
        .state = &board->state.script,
        .rig = &board->rig,
        .can = &mcu->can,
        .usart = &mcu->usart,
    };
    hil_command_script_create(&board->script);
    board->replay.core = &board->core;
    board->replay.state = &board->state.replay;
    board->replay.gpio = &mcu->gpio;
    board->replay.adc = &mcu->adc;
    board->replay.rcc = &mcu->rcc;
    board->replay.tim = &mcu->tim;
    board->replay.can = &mcu->can;
    board->replay.usart = &mcu->usart;
    board->replay.rig = &board->rig;
    hil_replay_create(&board->replay);
    board->faults = (struct hil_faults_device){
        .core = &board->core,
        .options = &board->options,
        .state = &board->state.faults,
        .lines = &board->lines,
        .rig = &board->rig,
        .camera = &board->camera,
        .supply = &board->supply,
        .rcc = &mcu->rcc,
        .can = &mcu->can,
        .i2c = &mcu->i2c,
        .nor = &board->state.nor_fault_requests,
        .thermometer = &board->state.tmp112,
    };
    hil_faults_create(&board->faults);
}

void hil_board_set_electronics(struct hil_board *board)
{
    hil_electronics_set_up(&board->electronics, &board->options, board->options.figures);
    board->mcu.adc.vdda_v = board->electronics.vdda_v;
    board->mcu.adc.errors = board->electronics.has_drawn_tolerances ? &board->electronics.adc_errors
                                                                    : NULL;
}

/* Connects the parts of a new board. Its options and memories are set; its other members are
 * zero. */
static void connect_board(struct hil_board *board)
{
    connect_core(board);
    connect_pins(board);
    hil_board_set_electronics(board);
    connect_chips(board);
    connect_links(board);
    connect_run_inputs(board);
}

/* ---- board type of an image, from its header (common/image.h) ---- */

/* Reads the board type from the header at the start of flash. Without a header, `type` stays
 * unchanged. */
static enum mr_status read_board_type(const uint8_t *flash, const struct hil_board_type **type,
                                      char *error, size_t size)
{
    struct mr_image image;
    enum mr_status status = mr_image_decode(&image, flash);
    /* MR_CRC: the image is damaged, but the header is readable */
    if (status != MR_OK && status != MR_CRC)
        return MR_OK;
    const struct hil_board_type *found = hil_board_type_by_number(image.board);
    if (!found) {
        snprintf(error, size,
                 "the image is for board %u, which this matrig-board does not support; use the "
                 "matrig-board that was built with the image",
                 image.board);
        return MR_VERSION;
    }
    *type = found;
    return MR_OK;
}

static bool read_elf(const char *path, struct hil_memory *memory)
{
    char unused[256];
    return path && hil_elf_load(path, memory, unused, sizeof unused) == MR_OK;
}

static bool read_flash(const char *path, struct hil_memory *memory)
{
    FILE *file = path ? fopen(path, "rb") : NULL;
    size_t n = file ? fread(memory->flash, 1, MR_IMAGE_HEAD_BYTES, file) : 0;
    if (file)
        fclose(file);
    return n == MR_IMAGE_HEAD_BYTES;
}

enum mr_status hil_board_type_from_files(const char *elf, const char *flash,
                                         const struct hil_board_type **type, char *error,
                                         size_t size)
{
    struct hil_memory *memory = hil_allocate(sizeof *memory);
    enum mr_status status = MR_OK;
    if (read_elf(elf, memory) || (!elf && read_flash(flash, memory)))
        status = read_board_type(memory->flash, type, error, size);
    free(memory);
    return status;
}

/* ---- the board ---- */

/* Fills RAM with random bytes: after a power failure its content is undefined. */
static void scramble_ram(struct hil_board *board)
{
    uint64_t random = board->options.noise_seed + board->core.state.counters.power_cuts;
    for (size_t i = 0; i < HIL_SRAM_SIZE + HIL_CCM_SIZE; i += 8) {
        uint64_t noise = mr_splitmix64(&random);
        memcpy(i < HIL_SRAM_SIZE ? board->core.memory->sram + i
                                 : board->core.memory->ccm + (i - HIL_SRAM_SIZE),
               &noise, 8);
    }
    hil_cpu_discard_code(&board->core);
}

/* Resets everything that is connected to the reset line. Time, rig, script, counters and SRAM keep
 * their state. */
static void reset_chip(struct hil_board *board, uint32_t csr_flags)
{
    struct hil_core *core = &board->core;
    core->reset.is_requested = false;
    core->reset.csr_flags = 0;
    hil_nvic_reset(&core->state.nvic);
    hil_scb_reset(&core->state.scb, board->options.type->idcode);
    hil_systick_reset(core);
    if (core->reset.has_lost_power) {
        core->reset.has_lost_power = false;
        board->state.mcu.rcc.csr = 0;
        scramble_ram(board);
    }
    hil_mcu_reset(&board->mcu, csr_flags);
    hil_cpu_reset(core);
}

static void handle_reset(struct hil_board *board)
{
    board->core.state.counters.resets++;
    hil_trace(&board->core, "reset, RCC_CSR flags 0x%08x", (unsigned)board->core.reset.csr_flags);
    reset_chip(board, board->core.reset.csr_flags);
}

void hil_board_reset(struct hil_board *board)
{
    if (board->core.state.cpu.is_stepping)
        hil_cpu_leave_block(&board->core);
    hil_core_request_reset(&board->core, 0);
    handle_reset(board);
}

/* Fits the maintenance jumper, which connects its pin to ground. */
static void fit_jumper(struct hil_board *board)
{
    struct hil_pin_location at = board->options.type->jumper_pin;
    hil_gpio_drive(&board->mcu.gpio, at.port, at.pin, false, 0);
}

struct hil_board *hil_board_create(const struct hil_options *options)
{
    struct hil_board *board = hil_allocate(sizeof *board);
    /* zero-filled and page-aligned; pages that are never touched use no memory */
    board->memories = mmap(NULL, sizeof *board->memories, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (board->memories == MAP_FAILED)
        abort();
    memset(board->memories->mcu.flash, 0xff, sizeof board->memories->mcu.flash);
    board->options = *options;
    if (options->has_random_tolerances)
        hil_electronics_chip_uid(options->tolerance_seed, board->options.uid);
    board->options.fault_log = NULL; /* nothing is logged until the board is complete */
    connect_board(board);
    for (unsigned i = 0; i < 2; i++)
        board->state.mcu.adc[i].random_state = options->noise_seed * 0x2545f4914f6cdd1dull +
                                               i * 0x632be59bd9b4e019ull;
    hil_cpu_create(&board->core);
    /* at rest, the one-shot and the outputs of camera, brake and wheel hold the capture pins low */
    for (unsigned i = 0; !options->has_no_rig && i < HIL_CAPTURE_CHANNELS; i++)
        hil_gpio_drive(&board->mcu.gpio, hil_capture_pins[i].port, hil_capture_pins[i].pin, false,
                       0);
    if (options->is_jumper_fitted)
        fit_jumper(board);
    hil_tmp112_power_on(&board->tmp112);
    reset_chip(board, HIL_CSR_POWER_ON);
    board->core.trace = options->trace;
    board->options.fault_log = options->fault_log;
    return board;
}

void hil_board_destroy(struct hil_board *board)
{
    if (!board)
        return;
    hil_cpu_destroy(&board->core);
    hil_symbols_free(&board->symbols);
    munmap(board->memories, sizeof *board->memories);
    free(board);
}

void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks)
{
    board->lines.callbacks = *callbacks;
}

/* Powers the board on with the present content of its memories. Fails if the firmware cannot
 * start. */
static enum mr_status restart_board(struct hil_board *board)
{
    hil_cpu_discard_code(&board->core);
    board->core.is_stopped = false;
    board->core.failure_reason[0] = '\0';
    reset_chip(board, HIL_CSR_POWER_ON);
    if (board->options.has_clocks_left_on)
        hil_rcc_leave_clocks_on(&board->mcu.rcc);
    return board->core.is_stopped ? board->core.stop_status : MR_OK;
}

/* Checks that flash content loaded from this file is for this board. MR_VERSION: it is for another
 * board, which the reason names. */
static enum mr_status check_board_type(struct hil_board *board, const char *path)
{
    const struct hil_board_type *type = board->options.type, *wanted = type;
    char why[160];
    enum mr_status status = read_board_type(board->core.memory->flash, &wanted, why, sizeof why);
    if (status != MR_OK)
        snprintf(board->core.failure_reason, sizeof board->core.failure_reason, "%s: %s", path,
                 why);
    if (status != MR_OK)
        return status;
    for (uint32_t i = type->flash_kib * 1024u; i < HIL_FLASH_SIZE; i++) {
        if (board->core.memory->flash[i] == 0xff)
            continue;
        snprintf(board->core.failure_reason, sizeof board->core.failure_reason,
                 "%s is larger than the flash of this chip (%u KiB); give the image for this board",
                 path, (unsigned)type->flash_kib);
        return MR_VERSION;
    }
    if (wanted->number == type->number)
        return MR_OK;
    snprintf(board->core.failure_reason, sizeof board->core.failure_reason,
             "%s is an image for board %s, but the emulated board is %s; give the image for this "
             "board, or leave --board out",
             path, hil_board_type_name(wanted), hil_board_type_name(type));
    return MR_VERSION;
}

/* Name of the function at an address. The image's symbols are read at the first use. */
static const char *find_function_name(void *context, uint32_t pc)
{
    struct hil_board *board = context;
    char error[256];
    if (!board->symbols.file && board->elf[0])
        (void)hil_symbols_read(&board->symbols, board->elf, error, sizeof error);
    const struct mr_symbol *symbol = mr_symbols_by_address(&board->symbols, pc);
    return symbol ? symbol->name : NULL;
}

/* Sets the ELF file whose function names are used in reports of rules; copies the path. */
static void set_symbol_file(struct hil_board *board, const char *elf)
{
    hil_symbols_free(&board->symbols);
    snprintf(board->elf, sizeof board->elf, "%s", elf);
    board->mcu.rules.get_function_name = find_function_name;
    board->mcu.rules.context = board;
}

enum mr_status hil_board_load_elf(struct hil_board *board, const char *path)
{
    enum mr_status status = hil_elf_load(path, board->core.memory, board->core.failure_reason,
                                         sizeof board->core.failure_reason);
    if (status == MR_OK)
        status = check_board_type(board, path);
    if (status != MR_OK)
        return status;
    set_symbol_file(board, path);
    return restart_board(board);
}

void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run)
{
    board->rig.run = run;
    hil_rig_start(&board->rig);
    hil_command_script_start(&board->script);
}

void hil_board_attach_replay(struct hil_board *board, const struct hil_replay *replay)
{
    board->state.replay = (struct hil_replay_state){0};
    hil_replay_connect(&board->replay, replay);
    fit_jumper(board); /* with the jumper the firmware accepts the command `replay` */
    if (replay->has_uid)
        memcpy(board->options.uid, replay->uid, sizeof board->options.uid);
    if (!replay->has_crystal)
        board->options.hse_hz = 0;
}

/* Advances to the next event and counts the skipped cycles. */
static void advance_to_event(struct hil_core *core, uint64_t *counter)
{
    struct hil_core_state *state = &core->state;
    /* at the latest the end of the run, which is an event too */
    uint64_t next = state->events.next_cycle;
    if (next > state->clock.now_cycle) {
        *counter += next - state->clock.now_cycle;
        state->clock.now_cycle = next;
    }
}

/* True if the core waits for flash: for its next instruction, or for the vector of an exception
 * that is due. */
static bool is_waiting_for_flash(struct hil_core *core)
{
    uint32_t pc = 0;
    if (!core->state.bank.is_busy)
        return false;
    uc_reg_read(core->uc, UC_ARM_REG_PC, &pc);
    return hil_memory_is_stalled(core, pc) ||
           (hil_exception_next(core) && hil_memory_is_stalled(core, core->state.scb.vtor));
}

enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps)
{
    struct hil_core *core = &board->core;
    struct hil_core_state *state = &core->state;
    const struct hil_observers *observers = &core->observers;
    if (core->is_stopped)
        return core->stop_status;
    core->has_reached_target = false;
    hil_event_set_ps(core, HIL_EVENT_RUN_END, t_ps);
    for (;;) {
        if (observers->debugger && observers->debugger->is_holding(observers->debugger_context))
            break;
        /* the core is inside a block, and no event is due before the end of the block */
        if (state->cpu.is_stepping) {
            hil_cpu_run(core);
            continue;
        }
        hil_event_handle_due(core);
        if (core->is_stopped || core->has_reached_target)
            break;
        if (core->reset.is_requested) {
            handle_reset(board);
            hil_supply_hold_reset(&board->supply);
            continue;
        }
        if (board->state.supply.is_held_in_reset) {
            advance_to_event(core, &state->counters.asleep_cycles);
            continue;
        }
        if (state->clock.is_stopped) {
            hil_core_skip_to_event(core);
            continue;
        }
        if (state->cpu.is_asleep) {
            if (hil_exception_can_wake(core)) {
                state->cpu.is_asleep = false;
            } else {
                if (observers->tracer)
                    observers->tracer->sample_signals(observers->tracer_context,
                                                      hil_now_cycle(core));
                advance_to_event(core, &state->counters.asleep_cycles);
                continue;
            }
            if (observers->tracer)
                observers->tracer->sample_signals(observers->tracer_context, hil_now_cycle(core));
        }
        if (is_waiting_for_flash(core)) {
            advance_to_event(core, &state->counters.flash_stall_cycles);
            continue;
        }
        unsigned exception = hil_exception_next(core);
        if (exception) {
            uint32_t pc = 0;
            uc_reg_read(core->uc, UC_ARM_REG_PC, &pc);
            hil_exception_enter(core, exception, pc);
            continue;
        }
        const struct hil_nvic *nvic = &state->nvic;
        bool masked = nvic->next_exception &&
                      nvic->next_group_priority < nvic->active_group_priority;
        core->next_check_cycle = masked || state->bank.is_busy ? 0 : state->events.next_cycle;
        hil_cpu_run(core);
    }
    hil_event_set_ps(core, HIL_EVENT_RUN_END, HIL_NEVER);
    hil_rig_count_excitation(&board->rig, hil_now_cycle(core));
    return core->is_stopped ? core->stop_status : MR_OK;
}

const char *hil_board_failure_reason(const struct hil_board *board)
{
    return board->core.failure_reason;
}

uint64_t hil_board_now_ps(const struct hil_board *board)
{
    return hil_now_ps(&board->core);
}

const struct hil_counters *hil_board_counters(const struct hil_board *board)
{
    return &board->core.state.counters;
}

bool hil_board_pin_level(const struct hil_board *board, unsigned port, unsigned pin)
{
    return port < HIL_GPIO_PORTS && pin < 16 && hil_gpio_level(&board->mcu.gpio, port, pin);
}

enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n)
{
    return hil_memory_peek(&board->core, address, out, n);
}

enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes,
                              size_t n)
{
    return hil_cpu_poke(&board->core, address, bytes, n);
}

/* ---- flash and NOR as files that outlast the program ---- */

#define OPTION_BYTES 16u

static enum mr_status record_file_failure(struct hil_board *board, enum mr_status status,
                                          const char *path, const char *why)
{
    snprintf(board->core.failure_reason, sizeof board->core.failure_reason, "%s: %s", path, why);
    return status;
}

bool hil_is_protected_file(const char *path)
{
    char begins[16] = {0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return false;
    ssize_t got = read(fd, begins, sizeof begins);
    close(fd);
    return got == (ssize_t)sizeof begins &&
           (memcmp(begins, "SQLite format 3", 16) == 0 || memcmp(begins, "\177ELF", 4) == 0);
}

/* Reads up to `room` bytes of a file. *n is 0, with MR_OK, if there is no file. */
static enum mr_status read_file(struct hil_board *board, const char *path, uint8_t *bytes,
                                size_t room, size_t *n)
{
    *n = 0;
    if (hil_is_protected_file(path))
        return record_file_failure(
            board, MR_MALFORMED, path,
            "the file is a database or a program and would be overwritten; give a different file");
    FILE *file = fopen(path, "rb");
    if (!file)
        return errno == ENOENT ? MR_OK : record_file_failure(board, MR_IO, path, strerror(errno));
    *n = fread(bytes, 1, room, file);
    bool failed = ferror(file) != 0, more = fgetc(file) != EOF;
    fclose(file);
    if (failed)
        return record_file_failure(board, MR_IO, path,
                                   "the file cannot be read; give a different file");
    if (more)
        return record_file_failure(
            board, MR_MALFORMED, path,
            "the file is larger than the emulated memory; give a different file");
    return MR_OK;
}

static enum mr_status write_file(struct hil_board *board, const char *path, const uint8_t *bytes,
                                 size_t n)
{
    char resolved[PATH_MAX], beside[PATH_MAX];
    const char *told = path;
    /* if the path is a symbolic link, replace its target and not the link */
    if (realpath(path, resolved))
        path = resolved;
    if ((size_t)snprintf(beside, sizeof beside, "%s.new", path) >= sizeof beside)
        return record_file_failure(board, MR_IO, told, "the path is too long; give a shorter one");
    FILE *file = fopen(beside, "wb");
    if (!file)
        return record_file_failure(board, MR_IO, told, strerror(errno));
    bool good = fwrite(bytes, 1, n, file) == n;
    good = fclose(file) == 0 && good;
    if (good && rename(beside, path) == 0)
        return MR_OK;
    remove(beside);
    return record_file_failure(
        board, MR_IO, told, "the file cannot be written; free disk space or give a different file");
}

static bool apply_option_bytes(struct hil_board *board, const uint8_t *bytes)
{
    uint16_t half[8];
    for (unsigned i = 0; i < 8; i++)
        half[i] = (uint16_t)(bytes[2 * i] | bytes[2 * i + 1] << 8);
    if ((half[0] ^ half[1]) != 0xffff || (half[4] ^ half[5]) != 0xffff)
        return false;
    board->state.mcu.flash.option_bytes = half[0] | (uint32_t)(half[4] & 0xfffu) << 16;
    return true;
}

enum mr_status hil_board_load_flash(struct hil_board *board, const char *path)
{
    uint8_t *bytes = hil_allocate(HIL_FLASH_SIZE + OPTION_BYTES);
    size_t n;
    memset(bytes, 0xff, HIL_FLASH_SIZE);
    enum mr_status status = read_file(board, path, bytes, HIL_FLASH_SIZE + OPTION_BYTES, &n);
    if (status == MR_OK && n > HIL_FLASH_SIZE &&
        (n != HIL_FLASH_SIZE + OPTION_BYTES || !apply_option_bytes(board, bytes + HIL_FLASH_SIZE)))
        status = record_file_failure(board, MR_MALFORMED, path,
                                     "not a flash file, because no valid option bytes follow the "
                                     "first MiB; give a different file");
    if (status == MR_OK && n) {
        memcpy(board->core.memory->flash, bytes, HIL_FLASH_SIZE);
        status = check_board_type(board, path);
    }
    if (status == MR_OK)
        status = restart_board(board);
    free(bytes);
    return status;
}

enum mr_status hil_board_save_flash(struct hil_board *board, const char *path)
{
    uint8_t *bytes = hil_allocate(HIL_FLASH_SIZE + OPTION_BYTES);
    bool factory = board->state.mcu.flash.option_bytes == HIL_FLASH_OPTIONS_FACTORY;
    memcpy(bytes, board->core.memory->flash, HIL_FLASH_SIZE);
    for (unsigned i = 0; i < OPTION_BYTES; i++)
        bytes[HIL_FLASH_SIZE + i] = (uint8_t)(hil_flash_option_word(&board->mcu.flash, i / 4u) >>
                                              (8u * (i % 4u)));
    enum mr_status status = write_file(board, path, bytes,
                                       HIL_FLASH_SIZE + (factory ? 0 : OPTION_BYTES));
    free(bytes);
    return status;
}

enum mr_status hil_board_load_nor(struct hil_board *board, const char *path)
{
    uint8_t *bytes = hil_allocate(HIL_NOR_SIZE);
    size_t n;
    enum mr_status status = read_file(board, path, bytes, HIL_NOR_SIZE, &n);
    if (status == MR_OK)
        status = hil_w25q_poke(&board->w25q, 0, bytes, n);
    free(bytes);
    return status;
}

enum mr_status hil_board_save_nor(struct hil_board *board, const char *path)
{
    uint8_t *bytes = hil_allocate(HIL_NOR_SIZE);
    enum mr_status status = hil_w25q_peek(&board->w25q, 0, bytes, HIL_NOR_SIZE);
    if (status == MR_OK)
        status = write_file(board, path, bytes, HIL_NOR_SIZE);
    free(bytes);
    return status;
}

enum mr_status hil_board_program_elf(struct hil_board *board, const char *path)
{
    uint8_t *old = hil_allocate(HIL_FLASH_SIZE), *flash = board->core.memory->flash;
    memcpy(old, flash, HIL_FLASH_SIZE);
    enum mr_status status = hil_board_load_elf(board, path);
    for (unsigned sector = 0; status == MR_OK && sector < HIL_FLASH_SECTORS; sector++) {
        uint32_t at = hil_flash_sector_start(sector), end = hil_flash_sector_start(sector + 1),
                 i = at;
        while (i < end && flash[i] == 0xff)
            i++;
        if (i == end)
            memcpy(flash + at, old + at, end - at);
    }
    free(old);
    return status;
}
