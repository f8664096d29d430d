#include "host/board/bringup.h"

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/crc32.h"
#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"

#define FORMAT_VERSION    1
#define TEXT_BYTES_MAX    65536u
/* time limit for the first line: after a reset the board takes 1 s, an emulated board on a busy
 * computer 10 s */
#define ANSWER_TIMEOUT_S  15.0
/* time limit between two lines, long enough for the watchdog test and for erasing memory and
 * flash */
#define SILENCE_TIMEOUT_S 30.0
#define TOTAL_TIMEOUT_S   120.0
#define RESEND_INTERVAL_S 3.0

/* ---- text ---- */

static enum mr_status parse_line(struct bringup *b, const char *line, size_t length,
                                 struct error *error)
{
    char copy[160], rest[8];
    if (b->line_count == BRINGUP_LINES_MAX || length >= sizeof copy)
        return error_set(error, MR_TOO_LONG,
                         "bring-up: the output has too many lines or a line that is too long; "
                         "check that the board runs the bring-up image");
    memcpy(copy, line, length);
    copy[length] = 0;
    struct bringup_line *l = &b->line[b->line_count];
    if (sscanf(copy, "%47s %39s %47s %7s", l->name, l->value, l->unit, rest) != 3)
        return error_set(error, MR_MALFORMED,
                         "bring-up: expected a line NAME VALUE UNIT, received '%s'; check the "
                         "cable and repeat the command",
                         copy);
    char *end;
    l->is_absent = strcmp(l->value, "none") == 0;
    l->number = strncmp(l->value, "0x", 2) == 0 ? (double)strtoul(l->value, &end, 16)
                                                : strtod(l->value, &end);
    /* "nan" and "inf" are treated as words, not as numbers */
    if (*end || end == l->value || !isfinite(l->number))
        l->number = (double)NAN;
    b->line_count++;
    return MR_OK;
}

static enum mr_status check_section_end(const struct bringup *b, const char *line, uint32_t crc,
                                        struct error *error)
{
    char section[BRINGUP_NAME_SIZE];
    unsigned lines, reported_crc;
    if (sscanf(line, "end %47s %u %8x", section, &lines, &reported_crc) != 3 ||
        strcmp(section, b->section) != 0)
        return error_set(error, MR_MALFORMED,
                         "bring-up: expected the end of section %.60s, received '%s'; check the "
                         "cable and repeat the command",
                         b->section, line);
    if (lines != b->line_count)
        return error_set(
            error, MR_TRUNCATED,
            "bring-up: only %zu of %u lines were received; check the cable and repeat the command",
            b->line_count, lines);
    if (reported_crc != crc)
        return error_set(error, MR_CRC,
                         "bring-up: the received lines have the checksum %08x, but the board sent "
                         "%08x; check the cable and repeat the command",
                         (unsigned)crc, reported_crc);
    return MR_OK;
}

/* Returns the length of the first line without its end, or SIZE_MAX if it has no end. */
static size_t find_line_length(const char *text, size_t length)
{
    const char *end = memchr(text, '\n', length);
    return end ? (size_t)(end - text) : SIZE_MAX;
}

/* Parses one section. `text` must not contain carriage returns. */
static enum mr_status parse_section(struct bringup *b, const char *text, size_t length,
                                    struct error *error)
{
    int format;
    size_t at = 0;
    if (sscanf(text, "begin %47s %d", b->section, &format) != 2)
        return error_set(error, MR_MALFORMED,
                         "bring-up: the first line is '%.40s' instead of begin SECTION FORMAT; "
                         "check the cable and repeat the command",
                         text);
    if (format != FORMAT_VERSION)
        return error_set(error, MR_VERSION,
                         "bring-up: the image uses format %d, but this matrig uses format %d; use "
                         "the matrig version that belongs to the image",
                         format, FORMAT_VERSION);
    for (bool first = true;; first = false) {
        size_t count = find_line_length(text + at, length - at);
        if (count == SIZE_MAX)
            return error_set(error, MR_TRUNCATED,
                             "bring-up: the output stopped in section %s after %zu lines; check "
                             "cable and supply, and repeat the command",
                             b->section, b->line_count);
        if (strncmp(text + at, "end ", 4) == 0) {
            b->length = at + count + 1u;
            return check_section_end(b, text + at, mr_crc32(0, (const uint8_t *)text, at), error);
        }
        enum mr_status status = first ? MR_OK : parse_line(b, text + at, count, error);
        if (status != MR_OK)
            return status;
        at += count + 1u;
    }
}

enum mr_status bringup_parse(struct bringup *b, const char *text, size_t length,
                             struct error *error)
{
    *b = (struct bringup){.line_count = 0};
    b->text = xcalloc(length + 1u, 1);
    size_t kept = 0;
    for (size_t i = 0; i < length; i++) { /* removes carriage returns, which terminals insert */
        if (text[i] != '\r')
            b->text[kept++] = text[i];
    }
    b->length = kept;
    enum mr_status status = parse_section(b, b->text, kept, error);
    b->text[b->length] = 0;
    return status;
}

void bringup_free(struct bringup *b)
{
    free(b->text);
    b->text = NULL;
}

const struct bringup_line *bringup_find(const struct bringup *b, const char *name)
{
    for (size_t i = 0; i < b->line_count; i++) {
        if (strcmp(b->line[i].name, name) == 0)
            return &b->line[i];
    }
    return NULL;
}

/* ---- from a link ---- */

struct receiver {
    char text[TEXT_BYTES_MAX + 1];
    size_t text_length;
    double received_s, started_s, sent_s;
    /* length of the received text at the "ready:" line after which the command word was last
     * sent */
    size_t ready_position;
    size_t received_byte_count; /* total of received bytes */
};

/* Returns the first line that begins with `word`, or NULL. */
static const char *find_line(const char *text, const char *word)
{
    for (const char *at = text; at; at = strchr(at, '\n')) {
        at += *at == '\n';
        if (strncmp(at, word, strlen(word)) == 0)
            return at;
    }
    return NULL;
}

/* Returns the section once it is complete. Skips another section that precedes it. */
static const char *find_complete_section(struct receiver *l, const char *section)
{
    char begin[64], end[64];
    snprintf(begin, sizeof begin, "begin %s ", section);
    snprintf(end, sizeof end, "end %s ", section);
    const char *from = find_line(l->text, begin);
    const char *to = from ? find_line(from, end) : NULL;
    return to && strchr(to, '\n') ? from : NULL;
}

static bool has_section_begun(const struct receiver *l, const char *section)
{
    char begin[64];
    snprintf(begin, sizeof begin, "begin %s ", section);
    return find_line(l->text, begin) != NULL;
}

/* Returns false if most bytes are not printable, as at a wrong baud rate. */
static bool has_received_text(const struct receiver *l)
{
    size_t others = 0;
    for (size_t i = 0; i < l->text_length; i++)
        others += (l->text[i] < ' ' || l->text[i] > '~') && !strchr("\r\n\t", l->text[i]);
    return l->text_length > 0 && others * 10u < l->text_length;
}

static enum mr_status set_silence_error(const struct receiver *l, const struct link *link,
                                        const char *section, struct error *error)
{
    if (has_section_begun(l, section))
        return error_set(error, MR_TRUNCATED,
                         "bring-up: the output stopped in section %s after %zu bytes: %s; check "
                         "cable and supply, reset the board and try again",
                         section, l->received_byte_count, link_get_spec(link));
    if (has_received_text(l))
        return error_set(error, MR_TIMEOUT,
                         "the board sent %zu bytes, but they do not answer `%s`: %s; check the "
                         "cable, reset the board and try again",
                         l->received_byte_count, section, link_get_spec(link));
    return error_set(error, MR_TIMEOUT,
                     "no bring-up image answered at %d baud (%zu bytes received): %s; flash the "
                     "bring-up image as described in docs/howto/bring-up.md",
                     BRINGUP_BAUD, l->received_byte_count, link_get_spec(link));
}

static enum mr_status receive_text(struct receiver *l, struct link *link, struct error *error)
{
    size_t count = 0;
    uint64_t host_us;
    struct pollfd poll_at = {.fd = link_fd(link), .events = POLLIN};
    enum mr_status status = link_receive_bytes(link, (uint8_t *)l->text + l->text_length,
                                               TEXT_BYTES_MAX - l->text_length, &count, &host_us,
                                               error);
    if (status == MR_TOO_FEW) {
        (void)poll(&poll_at, 1, 100);
        status = link_service(link, error);
        return status == MR_TOO_FEW ? MR_OK : status;
    }
    for (size_t i = l->text_length; status == MR_OK && i < l->text_length + count; i++) {
        if (l->text[i] == 0) /* a zero byte is noise, not the end of the text */
            l->text[i] = '?';
    }
    if (status == MR_OK && count) {
        l->received_s = monotonic_s();
        l->received_byte_count += count;
        l->text_length += count;
        l->text[l->text_length] = 0;
    }
    return status;
}

/* Removes bytes before a "begin" line, which are not part of a report, to make room. */
static void discard_noise(struct receiver *l)
{
    if (l->text_length > TEXT_BYTES_MAX / 2u && !find_line(l->text, "begin ")) {
        l->text_length = l->ready_position = 0;
        l->text[0] = 0;
    }
}

/* Sends the command word again if it may have been lost: while the board resets, or before its
 * program runs. It is sent again after "ready:" or after silence, but never once the section has
 * begun, because the board executes every copy. */
static enum mr_status resend_if_due(struct receiver *l, struct link *link, const char *section,
                                    struct error *error)
{
    char word[32];
    /* The leading newline ends any partial line that the board has received. */
    snprintf(word, sizeof word, "\n%s\n", section);
    if (has_section_begun(l, section))
        return MR_OK;
    const char *ready = NULL;
    for (const char *at = find_line(l->text, "ready:"); at; at = find_line(at + 1, "ready:"))
        ready = at;
    bool anew = ready && ready > l->text + l->ready_position;
    double now_s = monotonic_s();
    if (link_is_from_recording(link) || (!anew && now_s - l->received_s < RESEND_INTERVAL_S) ||
        (!anew && now_s - l->sent_s < RESEND_INTERVAL_S))
        return MR_OK;
    if (anew)
        l->ready_position = (size_t)(ready - l->text);
    l->sent_s = now_s;
    return link_send_bytes(link, (const uint8_t *)word, strlen(word), error);
}

static bool has_timed_out(const struct receiver *l)
{
    double now_s = monotonic_s();
    /* a section has begun; if it is another one, the requested one follows */
    bool begun = find_line(l->text, "begin ") != NULL;
    bool is_alive = begun || has_received_text(l); /* the board is slow but still sends */
    return now_s - (is_alive ? l->received_s : l->started_s) >
               (begun ? SILENCE_TIMEOUT_S : ANSWER_TIMEOUT_S) ||
           now_s - l->started_s > TOTAL_TIMEOUT_S || l->text_length == TEXT_BYTES_MAX;
}

/* Waits for the complete section, or, if `section` is NULL, for the line `answer`. */
static enum mr_status wait_for_bringup_section(struct receiver *l, struct link *link,
                                               const char *section, const char *answer,
                                               const char **from, struct error *error)
{
    const char *asked = section ? section : "rom";
    for (;;) {
        enum mr_status status = receive_text(l, link, error);
        *from = section ? find_complete_section(l, section) : find_line(l->text, answer);
        if (*from)
            return MR_OK;
        if (find_line(l->text, "the boot ROM does not listen here"))
            return error_set(error, MR_NOT_NOW,
                             "the boot ROM of this board cannot be reached on this port: %s; flash "
                             "the board as described in docs/howto/flash.md",
                             link_get_spec(link));
        if (status == MR_CLOSED && link_is_from_recording(link))
            return find_line(l->text, "begin ")
                     /* return an incomplete section too: bringup_parse reports what is missing */
                     ? MR_OK
                     : error_set(error, MR_MALFORMED,
                                 "the file contains no output of a bring-up image: %s; give the "
                                 "file that the terminal program saved",
                                 link_get_spec(link));
        if (status == MR_CLOSED)
            return error_set(
                error, MR_CLOSED,
                "the board closed the link: %s; check the cable, reset the board and try again",
                link_get_spec(link));
        if (status == MR_OK)
            status = resend_if_due(l, link, asked, error);
        if (status != MR_OK)
            return status;
        discard_noise(l);
        if (has_timed_out(l))
            return set_silence_error(l, link, asked, error);
    }
}

static enum mr_status request_section(struct receiver *l, struct link *link, const char *section,
                                      const char *answer, const char **from, struct error *error)
{
    enum mr_status status = link_is_from_recording(link) ? MR_OK
                                                         : link_set_baud(link, BRINGUP_BAUD, error);
    l->started_s = l->received_s = monotonic_s();
    l->sent_s = l->started_s - RESEND_INTERVAL_S;
    l->received_s -= RESEND_INTERVAL_S; /* send the first word at once */
    return status ?: wait_for_bringup_section(l, link, section, answer, from, error);
}

enum mr_status bringup_request(struct bringup *b, struct link *link, const char *section,
                               struct error *error)
{
    struct receiver *l = xcalloc(1, sizeof *l);
    const char *from = NULL;
    *b = (struct bringup){.line_count = 0};
    enum mr_status status = request_section(l, link, section, NULL, &from, error);
    if (status == MR_OK && !from)
        from = find_line(l->text, "begin ");
    if (status == MR_OK)
        status = bringup_parse(b, from, l->text_length - (size_t)(from - l->text), error);
    free(l);
    return status;
}

enum mr_status bringup_start_rom(struct link *link, struct error *error)
{
    struct receiver *l = xcalloc(1, sizeof *l);
    const char *from = NULL;
    enum mr_status status = request_section(l, link, NULL, "to the boot ROM", &from, error);
    free(l);
    return status;
}

/* ---- limits ---- */

enum { SECTION_REPORT = 1, SECTION_BROWN_OUT = 2, SECTION_ANY = 3 };

#define OK      BRINGUP_OK
#define SUSPECT BRINGUP_SUSPECT
#define WRONG   BRINGUP_WRONG

#define LIMIT(section, name, least, most, beyond, none, source, advice)
#define ALLOWED_WORDS(section, name, words, beyond, none, source, advice)
#define BOARD_FACT(section, name, fact, beyond, none, source, advice) \
    static double fact##_of(const struct mr_board *board)             \
    {                                                                 \
        return board ? (double)board->fact : (double)NAN;             \
    }
#include "host/board/bringup_limits.def"

static const struct bringup_limit limits[] = {
#define LIMIT(section, name, least, most, beyond, none, source, advice) \
    {section, name, NULL, least, most, NULL, beyond, none, source, advice},
#define ALLOWED_WORDS(section, name, words, beyond, none, source, advice) \
    {section, name, words, 0.0, 0.0, NULL, beyond, none, source, advice},
#define BOARD_FACT(section, name, fact, beyond, none, source, advice) \
    {section, name, NULL, 0.0, 0.0, fact##_of, beyond, none, source, advice},
#include "host/board/bringup_limits.def"
};
#define LIMIT_COUNT (sizeof limits / sizeof limits[0])

static unsigned get_section_bit(const char *section)
{
    return strcmp(section, "report") == 0 ? SECTION_REPORT : SECTION_BROWN_OUT;
}

bool bringup_limit_is_group(const struct bringup_limit *limit)
{
    return limit->name[strlen(limit->name) - 1u] == '*';
}

static bool limit_matches_name(const struct bringup_limit *limit, const char *name)
{
    return bringup_limit_is_group(limit) ? strncmp(limit->name, name, strlen(limit->name) - 1u) == 0
                                         : strcmp(limit->name, name) == 0;
}

/* Finds the limit for a line. A line with the value `none` may stand for a whole group: `noise
 * none` covers all noise_ lines. */
static const struct bringup_limit *find_limit(unsigned section, const struct bringup_line *line)
{
    for (size_t i = 0; i < LIMIT_COUNT; i++) {
        if (limits[i].section_bits & section &&
            (limit_matches_name(&limits[i], line->name) ||
             (line->is_absent && strncmp(limits[i].name, line->name, strlen(line->name)) == 0)))
            return &limits[i];
    }
    return NULL;
}

/* True if `word` is one of the blank-separated `words`. */
static bool is_allowed_word(const char *words, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = strstr(words, word); at; at = strstr(at + 1, word)) {
        if ((at == words || at[-1] == ' ') && (at[length] == 0 || at[length] == ' '))
            return true;
    }
    return false;
}

static bool is_within_limit(const struct bringup_result *j)
{
    const char *words = j->limit->words;
    if (words)
        return !*words || is_allowed_word(words, j->line->value);
    return j->line->number >= j->min && j->line->number <= j->max;
}

static const struct mr_board *find_board(const struct bringup *bringup)
{
    const struct bringup_line *line = bringup_find(bringup, "board");
    int number = line ? mr_board_number_by_name(line->value) : -1;
    return number < 0 ? NULL : mr_board_by_number((unsigned)number);
}

static void compare_with_limit(struct bringup_result *j, const struct mr_board *board)
{
    const struct bringup_limit *limit = j->limit;
    if (limit) {
        j->min = limit->board_value ? limit->board_value(board) : limit->min;
        j->max = limit->board_value ? j->min : limit->max;
    }
    j->verdict = !j->limit          ? BRINGUP_SUSPECT
               : j->line->is_absent ? j->limit->verdict_if_missing
               : is_within_limit(j) ? BRINGUP_OK
                                    : j->limit->verdict_if_outside;
}

static bool has_line_for_limit(const struct bringup *bringup, unsigned section,
                               const struct bringup_limit *limit)
{
    for (size_t i = 0; i < bringup->line_count; i++) {
        if (find_limit(section, &bringup->line[i]) == limit)
            return true;
    }
    return false;
}

size_t bringup_check_limits(const struct bringup *bringup,
                            struct bringup_result results[BRINGUP_RESULTS_MAX])
{
    unsigned section = get_section_bit(bringup->section);
    const struct mr_board *board = find_board(bringup);
    size_t count = 0;
    for (size_t i = 0; i < bringup->line_count; i++) {
        struct bringup_result *j = &results[count++];
        *j = (struct bringup_result){.name = bringup->line[i].name,
                                     .line = &bringup->line[i],
                                     .limit = find_limit(section, &bringup->line[i])};
        compare_with_limit(j, board);
    }
    for (size_t i = 0; i < LIMIT_COUNT; i++) {
        const struct bringup_limit *limit = &limits[i];
        if (!(limit->section_bits & section) || limit->verdict_if_missing == BRINGUP_OK ||
            has_line_for_limit(bringup, section, limit))
            continue;
        results[count++] = (struct bringup_result){
            .name = limit->name, .limit = limit, .verdict = limit->verdict_if_missing};
    }
    return count;
}

enum bringup_verdict bringup_worst_verdict(const struct bringup_result *results, size_t count)
{
    enum bringup_verdict worst = BRINGUP_OK;
    for (size_t i = 0; i < count; i++)
        worst = results[i].verdict > worst ? results[i].verdict : worst;
    return worst;
}

const char *bringup_verdict_text(enum bringup_verdict verdict)
{
    static const char *const text[] = {"ok", "look", "wrong"};
    return text[verdict];
}
