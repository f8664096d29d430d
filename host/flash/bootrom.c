#include "host/flash/bootrom.h"

#include <string.h>

#define ACK    0x79u
#define NACK   0x1fu
#define SYNC   0x7fu
#define GET    0x00u
#define GET_ID 0x02u
#define READ   0x11u
#define GO     0x21u
#define WRITE  0x31u
#define ERASE  0x44u

/* Completes whatever the ROM waits for without doing anything: no command, no complement of itself,
 * no address in memory (four of them and their XOR do not agree), no sector (there are 12), and as
 * a count of sectors, 0x0c0c, it asks for 6171 bytes. A count that was damaged asks for up to
 * 65537: 6 s at 115200 baud. */
#define FILLER        0x0cu
#define CHUNK         256u
#define RESYNC_ROUNDS 12u
#define SYNC_TRIES    3u
/* 0x7f7f taken as a count of sectors asks for 2 * (0x7f7f + 1) + 1 bytes: 6 s */
#define SYNC_CHUNKS   258u
#define QUIET_MS      30u /* a byte takes 0.1 ms, an adapter holds bytes back for up to 16 */
#define DRAIN_MAX     70000u
#define BABBLE        600u /* more than any answer: somebody else speaks */
#define PROBE_MS      250u

/* How an exchange ended. */
enum outcome {
    DONE,
    REFUSED, /* NACK */
    SILENT,  /* no answer */
    GARBLED, /* an answer that is none */
    BROKEN,  /* the line is gone; the error is set */
};

enum stage { AT_COMMAND, AT_ADDRESS, AT_DATA };

struct exchange {
    struct bootrom *rom;
    struct error *error;
    enum stage stage; /* reached */
};

static enum outcome put(struct exchange *x, const uint8_t *bytes, size_t count)
{
    x->rom->sent += count;
    return x->rom->line->send(x->rom->line->context, bytes, count, x->error) == MR_OK ? DONE
                                                                                      : BROKEN;
}

static enum outcome get(struct exchange *x, uint8_t *byte, unsigned timeout_ms)
{
    enum mr_status status = x->rom->line->receive(x->rom->line->context, byte, timeout_ms,
                                                  x->error);
    if (status == MR_TIMEOUT && x->error->status == MR_OK)
        return SILENT;
    x->rom->received += status == MR_OK;
    return status == MR_OK ? DONE : BROKEN;
}

static enum outcome answer(struct exchange *x, unsigned timeout_ms)
{
    uint8_t byte;
    enum outcome outcome = get(x, &byte, timeout_ms);
    if (outcome != DONE)
        return outcome;
    return byte == ACK ? DONE : byte == NACK ? REFUSED : GARBLED;
}

/* Bytes with their XOR behind (of a single byte: its complement), and the answer. */
static enum outcome checked(struct exchange *x, const uint8_t *bytes, size_t count,
                            unsigned timeout_ms)
{
    uint8_t out[BOOTROM_PAGE + 2], sum = count == 1 ? 0xff : 0;
    for (size_t i = 0; i < count; i++)
        sum ^= out[i] = bytes[i];
    out[count] = sum;
    enum outcome outcome = put(x, out, count + 1);
    return outcome == DONE ? answer(x, timeout_ms) : outcome;
}

static enum outcome command(struct exchange *x, uint8_t code)
{
    x->stage = AT_COMMAND;
    return checked(x, &code, 1, x->rom->answer_ms);
}

static enum outcome command_at(struct exchange *x, uint8_t code, uint32_t address)
{
    const uint8_t bytes[4] = {(uint8_t)(address >> 24), (uint8_t)(address >> 16),
                              (uint8_t)(address >> 8), (uint8_t)address};
    enum outcome outcome = command(x, code);
    if (outcome != DONE)
        return outcome;
    x->stage = AT_ADDRESS;
    return checked(x, bytes, sizeof bytes, x->rom->answer_ms);
}

/* Bytes that nobody asked for. GARBLED: they do not end, or are more than a boot ROM has to say. */
static enum outcome drain(struct exchange *x, unsigned quiet_ms)
{
    uint8_t byte;
    unsigned babble = 0;
    enum outcome outcome = DONE;
    for (unsigned i = 0; outcome == DONE && i < DRAIN_MAX && babble < BABBLE; i++) {
        outcome = get(x, &byte, quiet_ms);
        babble += outcome == DONE && byte != ACK && byte != NACK;
    }
    return outcome == SILENT ? DONE : outcome == BROKEN ? BROKEN : GARBLED;
}

/* A count less one, as many bytes, and ACK. */
static enum outcome reply(struct exchange *x, uint8_t *bytes, size_t size, size_t *count)
{
    uint8_t less_one;
    enum outcome outcome = get(x, &less_one, x->rom->answer_ms);
    if (outcome == DONE && less_one >= size)
        return GARBLED;
    for (size_t i = 0; outcome == DONE && i <= less_one; i++)
        outcome = get(x, &bytes[i], x->rom->answer_ms);
    *count = less_one + 1u;
    return outcome == DONE ? answer(x, x->rom->answer_ms) : outcome;
}

static enum outcome ask(struct exchange *x, uint8_t code, uint8_t *bytes, size_t size,
                        size_t *count)
{
    enum outcome outcome = command(x, code);
    return outcome == DONE ? reply(x, bytes, size, count) : outcome;
}

/* Does the ROM wait for a command? GET says so by its whole answer. */
static enum outcome probe(struct exchange *x)
{
    const uint8_t bytes[] = {GET, GET ^ 0xff};
    uint8_t commands[32];
    size_t count;
    enum outcome outcome = put(x, bytes, sizeof bytes);
    if (outcome == DONE)
        outcome = answer(x, PROBE_MS);
    return outcome == DONE ? reply(x, commands, sizeof commands, &count) : outcome;
}

static enum outcome fill(struct exchange *x, uint8_t byte, unsigned count)
{
    uint8_t bytes[CHUNK];
    enum outcome outcome = DONE;
    memset(bytes, byte, sizeof bytes);
    for (; outcome == DONE && count; count -= count < CHUNK ? count : CHUNK)
        outcome = put(x, bytes, count < CHUNK ? count : CHUNK);
    return outcome;
}

/* Back in step: what the ROM waits for is filled up until it answers GET. Odd numbers, so that
 * pairs change step too. NACK: it took our two bytes for the second of one pair and the first of
 * another, which one byte completes. */
static enum outcome resynchronise(struct exchange *x)
{
    static const unsigned amounts[] = {1, 15, 301, 6201, 59401};
    unsigned silent = 0;
    enum outcome outcome = DONE;
    for (unsigned round = 0; round < RESYNC_ROUNDS; round++) {
        outcome = drain(x, QUIET_MS);
        if (outcome != DONE)
            break;
        outcome = probe(x);
        if (outcome == DONE || outcome == BROKEN ||
            (outcome == SILENT && silent == sizeof amounts / sizeof amounts[0]))
            break;
        enum outcome filled = fill(x, FILLER, outcome == SILENT ? amounts[silent] : 1);
        silent += outcome == SILENT;
        if (filled == BROKEN)
            return BROKEN;
    }
    return outcome;
}

static const char *line_name(const struct exchange *x)
{
    return x->rom->line->name;
}

static enum mr_status silence(const struct exchange *x, const char *what, uint32_t address)
{
    return error_set(x->error, MR_TIMEOUT,
                     "the boot ROM stopped answering (%s 0x%08x): %s; check cable and supply, then "
                     "run it again: "
                     "it goes on where it was",
                     what, (unsigned)address, line_name(x));
}

static enum mr_status nonsense(const struct exchange *x, const char *what, uint32_t address)
{
    return error_set(x->error, MR_IO,
                     "the boot ROM's answers are garbled, %u tries (%s 0x%08x): %s; give a lower "
                     "--baud, check the cable",
                     BOOTROM_TRIES, what, (unsigned)address, line_name(x));
}

/* What the last try of an exchange came to, in words. */
static enum mr_status failed(const struct exchange *x, enum outcome outcome, const char *what,
                             uint32_t address)
{
    static const char *const stages[] = {"the command", "the address", "the data"};
    if (outcome == BROKEN)
        return x->error->status;
    if (outcome == SILENT)
        return silence(x, what, address);
    if (outcome == GARBLED)
        return nonsense(x, what, address);
    return error_set(
        x->error, MR_IO,
        "the boot ROM refuses %s, %u tries (%s 0x%08x): %s; check the cable, give a lower --baud",
        stages[x->stage], BOOTROM_TRIES, what, (unsigned)address, line_name(x));
}

/* Between two tries. Also after NACK, which a flipped count brings while the rest of the page is
 * still on its way: what comes then is taken for commands. Anything but DONE: there is no use in
 * another try. */
static enum outcome recover(struct exchange *x)
{
    x->rom->repeated++;
    return resynchronise(x);
}

/* ---- beginning ---- */

/* A ROM that waits for 0x7F answers ACK; one that was spoken to before takes two for a pair that is
 * none, NACK; one that waits for the rest of a page or an address gets more of them. */
static enum outcome find(struct exchange *x)
{
    const uint8_t sync = SYNC;
    enum outcome outcome = drain(x, QUIET_MS);
    for (unsigned i = 0; outcome == DONE || outcome == SILENT; i++) {
        if (i == SYNC_TRIES)
            break;
        outcome = put(x, &sync, 1);
        if (outcome == DONE)
            outcome = answer(x, PROBE_MS);
        if (outcome == DONE || outcome == REFUSED || outcome == GARBLED)
            return outcome;
    }
    if (outcome != SILENT)
        return outcome;
    for (unsigned i = 0; outcome == SILENT && i < SYNC_CHUNKS; i++) {
        outcome = fill(x, SYNC, CHUNK);
        if (outcome == DONE)
            outcome = answer(x, 1);
    }
    return outcome;
}

static bool has(const uint8_t *commands, size_t count, uint8_t command_code)
{
    return memchr(commands, command_code, count) != NULL;
}

static enum mr_status learn(struct exchange *x)
{
    static const uint8_t needed[] = {GET_ID, READ, GO, WRITE, ERASE};
    uint8_t bytes[32];
    size_t count = 0;
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = ask(x, GET, bytes, sizeof bytes, &count);
        bool whole = outcome == DONE && count >= 2;
        for (size_t i = 0; whole && i < sizeof needed; i++)
            whole = has(bytes + 1, count - 1, needed[i]);
        if (whole || outcome == BROKEN)
            break;
        if (outcome == DONE && try + 1 == BOOTROM_TRIES)
            return error_set(
                x->error, MR_VERSION,
                "a boot ROM without the commands needed (version %u.%u): %s; is it an STM32F407?",
                bytes[0] >> 4, bytes[0] & 15u, line_name(x));
        enum outcome back = recover(x);
        if (back != DONE)
            return failed(x, back, "asking for its commands", 0);
    }
    if (outcome != DONE)
        return failed(x, outcome, "asking for its commands", 0);
    x->rom->version = bytes[0];
    return MR_OK;
}

static enum mr_status identify(struct exchange *x)
{
    uint8_t bytes[8];
    size_t count = 0;
    unsigned wanted = x->rom->wanted ? x->rom->wanted : BOOTROM_CHIP;
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = ask(x, GET_ID, bytes, sizeof bytes, &count);
        x->rom->chip = (uint16_t)(bytes[0] << 8 | bytes[1]);
        if (outcome == BROKEN || (outcome == DONE && count == 2 && x->rom->chip == wanted))
            break;
        enum outcome back = recover(x);
        if (back != DONE)
            return failed(x, back, "asking for its chip", 0);
    }
    if (outcome != DONE)
        return failed(x, outcome, "asking for its chip", 0);
    if (count != 2 || x->rom->chip != wanted)
        return error_set(
            x->error, MR_VERSION,
            "another chip: id 0x%03x, and the image is for one with 0x%03x: %s; is it the right "
            "board, and the image of that board?",
            x->rom->chip, wanted, line_name(x));
    return MR_OK;
}

enum mr_status bootrom_begin(struct bootrom *rom, const struct bootrom_line *line,
                             struct error *error)
{
    struct exchange x = {.rom = rom, .error = error};
    rom->line = line;
    if (!rom->answer_ms)
        rom->answer_ms = BOOTROM_ANSWER_MS;
    enum outcome outcome = find(&x);
    if (outcome == DONE || outcome == REFUSED || outcome == GARBLED)
        outcome = resynchronise(&x);
    if (outcome == BROKEN)
        return error->status;
    if (outcome == GARBLED)
        return error_set(error, MR_TIMEOUT,
                         "no boot ROM, something else speaks there: %s; the firmware? Give "
                         "--enter, or start the board "
                         "with BOOT0 high",
                         line->name);
    if (outcome != DONE)
        return error_set(error, MR_TIMEOUT,
                         "no boot ROM answers: %s; start the board with BOOT0 high, on USART1; one "
                         "that was spoken to "
                         "before keeps that --baud",
                         line->name);
    enum mr_status status = learn(&x);
    return status == MR_OK ? identify(&x) : status;
}

/* ---- reading, writing, erasing, going ---- */

static enum outcome read_once(struct exchange *x, uint32_t address, uint8_t *bytes, size_t count)
{
    uint8_t less_one = (uint8_t)(count - 1);
    enum outcome outcome = command_at(x, READ, address);
    if (outcome != DONE)
        return outcome;
    x->stage = AT_DATA;
    outcome = checked(x, &less_one, 1, x->rom->answer_ms);
    for (size_t i = 0; outcome == DONE && i < count; i++)
        outcome = get(x, &bytes[i], x->rom->answer_ms);
    return outcome;
}

enum mr_status bootrom_read(struct bootrom *rom, uint32_t address, uint8_t *bytes, size_t count,
                            struct error *error)
{
    struct exchange x = {.rom = rom, .error = error};
    unsigned refused = 0;
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = read_once(&x, address, bytes, count);
        if (outcome == DONE)
            return MR_OK;
        refused += outcome == REFUSED && x.stage == AT_COMMAND;
        enum outcome back = outcome == BROKEN ? BROKEN : recover(&x);
        if (back != DONE)
            return failed(&x, back, "reading", address);
    }
    if (refused == BOOTROM_TRIES) /* it obeys GET and refuses this each time */
        return error_set(
            error, MR_NOT_NOW,
            "the chip is read-protected: %s; stm32flash -k lifts it, which erases everything, the "
            "configuration too",
            rom->line->name);
    return failed(&x, outcome, "reading", address);
}

static enum outcome write_once(struct exchange *x, uint32_t address, const uint8_t *bytes,
                               size_t count)
{
    uint8_t out[BOOTROM_PAGE + 1];
    enum outcome outcome = command_at(x, WRITE, address);
    if (outcome != DONE)
        return outcome;
    out[0] = (uint8_t)(count - 1);
    memcpy(out + 1, bytes, count);
    x->stage = AT_DATA;
    return checked(x, out, count + 1, x->rom->answer_ms);
}

/* After an unclear end: MR_OK: the page is there; MR_TOO_FEW: it is blank; MR_WAIT: neither. */
static enum mr_status look(struct exchange *x, uint32_t address, const uint8_t *bytes, size_t count)
{
    uint8_t back[BOOTROM_PAGE];
    bool equal, blank;
    for (unsigned i = 0; i < 2; i++) { /* twice: what READ answers has no checksum */
        enum mr_status status = bootrom_read(x->rom, address, back, count, x->error);
        if (status != MR_OK)
            return status;
        equal = memcmp(back, bytes, count) == 0;
        blank = true;
        for (size_t k = 0; k < count; k++)
            blank = blank && back[k] == 0xff;
        if (equal || blank)
            break;
    }
    return equal ? MR_OK : blank ? MR_TOO_FEW : MR_WAIT;
}

enum mr_status bootrom_write(struct bootrom *rom, uint32_t address, const uint8_t *bytes,
                             size_t count, struct error *error)
{
    struct exchange x = {.rom = rom, .error = error};
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = write_once(&x, address, bytes, count);
        if (outcome == DONE)
            return MR_OK;
        enum stage stage = x.stage;
        enum outcome back = outcome == BROKEN ? BROKEN : recover(&x);
        if (back != DONE)
            return failed(&x, back, "writing", address);
        enum mr_status seen = look(&x, address, bytes, count);
        if (seen != MR_TOO_FEW)
            return seen;
        x.stage = stage;
    }
    return failed(&x, outcome, "writing", address);
}

/* One sector to a command: an erase that fails or a board that is pulled out concerns no other. */
static enum outcome erase_once(struct exchange *x, unsigned sector)
{
    const uint8_t list[4] = {0, 0, 0, (uint8_t)sector};
    enum outcome outcome = command(x, ERASE);
    if (outcome != DONE)
        return outcome;
    x->stage = AT_DATA;
    return checked(x, list, sizeof list,
                   x->rom->answer_ms > BOOTROM_ERASE_MS ? x->rom->answer_ms : BOOTROM_ERASE_MS);
}

enum mr_status bootrom_erase(struct bootrom *rom, unsigned sector, struct error *error)
{
    struct exchange x = {.rom = rom, .error = error};
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = erase_once(&x, sector);
        if (outcome == DONE)
            return MR_OK;
        enum outcome back = outcome == BROKEN ? BROKEN : recover(&x);
        if (back != DONE)
            return failed(&x, back, "erasing sector", sector);
    }
    if (outcome == REFUSED)
        return error_set(error, MR_NOT_NOW,
                         "the boot ROM refuses to erase sector %u: %s; is it write-protected? "
                         "stm32flash -u lifts that",
                         sector, rom->line->name);
    return failed(&x, outcome, "erasing sector", sector);
}

enum mr_status bootrom_go(struct bootrom *rom, uint32_t address, struct error *error)
{
    struct exchange x = {.rom = rom, .error = error};
    enum outcome outcome = SILENT;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        outcome = command_at(&x, GO, address);
        if (outcome == DONE)
            return MR_OK;
        if (outcome == BROKEN)
            return error->status;
        /* An answer that got lost: the ROM has gone already, and whoever answers now is another
         * program. */
        enum stage stage = x.stage;
        enum outcome back = recover(&x);
        if (back == SILENT && stage == AT_ADDRESS)
            return MR_OK;
        if (back != DONE)
            return failed(&x, back, "starting", address);
    }
    return failed(&x, outcome, "starting", address);
}
