/* The bring-up image: at power on, and whenever `report` is typed, a whole report; then commands.
 * Two of its parts end in a reset, after which it goes on where it was. */
#include <string.h>

#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define REPORT_ROUNDS 3u    /* of the memory test, in a report */
#define ROUNDS        1000u /* and of the command */
#define WORD_BYTES    16u

/* Where the report is; kept through resets, with its complement, for at power on RAM holds
 * anything. */
enum stage { STAGE_NONE, STAGE_STACK, STAGE_WATCHDOG };
static struct {
    uint32_t stage, complement;
} kept __attribute__((section(".noinit")));

static void keep_stage(enum stage stage)
{
    kept.stage = stage;
    kept.complement = ~(uint32_t)stage;
}

static enum stage take_stage(void)
{
    enum stage stage = kept.complement == ~kept.stage && kept.stage <= STAGE_WATCHDOG
                         ? (enum stage)kept.stage
                         : STAGE_NONE;
    keep_stage(STAGE_NONE);
    return stage;
}

static void begin(const char *section)
{
    say_begin(section);
    bringup_identity();
}

static void end_report(void)
{
    say_end();
    say_text("ready: report, memory, brown-out, rom");
}

static void go_on_with_watchdog(void)
{
    bringup_say_overflow();
    say_flush();
    keep_stage(STAGE_WATCHDOG);
    bringup_starve_watchdog();
    bringup_say_watchdog(); /* it let us live: that is said */
    end_report();
}

static void report(void)
{
    begin("report");
    bringup_chip();
    bringup_options();
    bringup_clocks();
    bringup_noise();
    bringup_cost();
    bringup_can();
    bringup_memory(REPORT_ROUNDS);
    say_flush();
    keep_stage(STAGE_STACK);
    bringup_overflow_stack();
}

static void go_on(enum stage stage)
{
    if (stage == STAGE_STACK) {
        go_on_with_watchdog();
    } else if (stage == STAGE_WATCHDOG) {
        bringup_say_watchdog();
        end_report();
    } else {
        say_text("matrig bring-up");
        report();
    }
}

/* Where the ROM does not listen at this port nobody would find it there. */
static void enter_rom(void)
{
    if (!BOARD_ROM_HEARS_SERIAL) {
        say_text("the boot ROM does not listen here");
        return;
    }
    say_text("to the boot ROM");
    say_flush();
    board_enter_rom();
}

/* Words said meanwhile, by one who thought that the first was lost: each would wear the memory. */
static void drop_words(void)
{
    uint8_t byte;
    while (board_serial_receive(&byte, 1) == 1) {
    }
}

static void obey(const char *word)
{
    if (strcmp(word, "report") == 0) {
        report();
    } else if (strcmp(word, "memory") == 0) {
        begin("memory");
        bringup_memory(ROUNDS);
        say_end();
        drop_words();
    } else if (strcmp(word, "brown-out") == 0) {
        begin("brown-out");
        bringup_set_brown_out();
        say_end();
    } else if (strcmp(word, "rom") == 0) {
        enter_rom();
    } else if (*word) {
        say_text("not report, memory, brown-out or rom");
    }
}

/* A line that came, without its end; false: none yet. */
static bool take_word(char word[WORD_BYTES])
{
    static char line[WORD_BYTES];
    static size_t length;
    uint8_t byte;
    while (board_serial_receive(&byte, 1) == 1) {
        if (byte == '\r' || byte == '\n') {
            memcpy(word, line, WORD_BYTES);
            memset(line, 0, sizeof line);
            length = 0;
            return true;
        }
        if (length < WORD_BYTES - 1u)
            line[length++] = (char)byte;
    }
    return false;
}

int main(void)
{
    struct board_identity identity;
    struct mr_block block;
    char word[WORD_BYTES];
    board_start();
    board_note_good(); /* resets are what it is for: no row of them */
    board_identify(&identity);
    pace_start(identity.clock_source == BOARD_CLOCK_RAW ? 16u : 168u);
    uart_rate(SAY_BAUD);
    board_scans_configure(board_inputs());
    go_on(take_stage());
    for (;;) {
        watchdog_feed();
        while (board_block_take(&block)) { /* or there is no sleep */
        }
        (void)board_sleep();
        if (take_word(word))
            obey(word);
    }
}
