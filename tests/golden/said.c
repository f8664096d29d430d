/* What the board said. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "common/framing.h"
#include "tests/golden/golden.h"

#define LINE      1024
#define CHUNK     4096
#define WHOLE_MAX 1e15

const char *const golden_link_text[GOLDEN_LINKS] = {"serial", "CAN"};

/* ---- decoding ---- */

struct listening {
    struct golden_said *said;
    const struct golden_given *given;
    long near[GOLDEN_LINKS]; /* newest block that the link has told of */
    size_t echoed;           /* block records that came back */
    bool faithful;
};

static bool has_block_field(const struct mr_message_info *info)
{
    return strcmp(info->fields[info->field_count - 1].name, "block16") == 0;
}

static struct golden_kind *find_kind(struct golden_said *said, enum golden_link link,
                                     const char *name)
{
    for (size_t i = 0; i < said->kinds; i++) {
        if (said->kind[i].link == link && strcmp(said->kind[i].name, name) == 0)
            return &said->kind[i];
    }
    return NULL;
}

/* A float field has no resolution of its own; an integer counts by one. */
static double step_of(const struct mr_field_info *field)
{
    if (field->type == MR_WIRE_f32)
        return 0.0;
    return field->counts_per_unit > 0.0f ? 1.0 / (double)field->counts_per_unit : 1.0;
}

/* The value as people write it: of a scaled field the count in its steps, of a single the shortest
 * that is the same single. */
static double plain_value(const struct mr_field_info *field, const uint8_t *payload)
{
    char text[40];
    double value = mr_field_value(field, payload);
    if (isnan(value))
        return value;
    if (field->type != MR_WIRE_f32)
        return field->counts_per_unit > 0.0f
                 ? round(value * (double)field->counts_per_unit) / (double)field->counts_per_unit
                 : value;
    for (int digits = 1; digits <= 9; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtof(text, NULL) == (float)value)
            break;
    }
    return strtod(text, NULL);
}

static struct golden_kind *new_kind(struct golden_said *said, enum golden_link link,
                                    const struct mr_message_info *info)
{
    said->kind = golden_grow(said->kind, said->kinds, sizeof *said->kind);
    struct golden_kind *kind = &said->kind[said->kinds++];
    *kind = (struct golden_kind){.link = link, .own_block = has_block_field(info)};
    snprintf(kind->name, sizeof kind->name, "%s", info->name);
    for (unsigned i = 0; i < info->field_count - (kind->own_block ? 1u : 0u); i++) {
        const struct mr_field_info *from = &info->fields[i];
        struct golden_field *field = &kind->field[kind->fields];
        if (golden_excluded(info->name, from->name))
            continue;
        snprintf(field->name, sizeof field->name, "%s", from->name);
        snprintf(field->unit, sizeof field->unit, "%s", from->unit);
        field->step = step_of(from);
        kind->fields++;
    }
    return kind;
}

static void take_message(struct listening *l, enum golden_link link, uint16_t id,
                         const uint8_t *payload, size_t length)
{
    const struct mr_message_info *info = mr_message_find(id);
    if (!info || info->direction == MR_DIRECTION_HOST || info->length != length ||
        golden_excluded(info->name, NULL))
        return;
    struct golden_kind *kind = find_kind(l->said, link, info->name);
    if (!kind)
        kind = new_kind(l->said, link, info);
    kind->row = golden_grow(kind->row, kind->rows, sizeof *kind->row);
    struct golden_row *row = &kind->row[kind->rows++];
    if (kind->own_block) {
        uint16_t low = (uint16_t)mr_field_value(&info->fields[info->field_count - 1], payload);
        l->near[link] += (int16_t)(uint16_t)(low - (uint16_t)l->near[link]);
    }
    row->at = l->near[link];
    for (unsigned i = 0, n = 0; i < info->field_count && n < kind->fields; i++) {
        if (strcmp(info->fields[i].name, kind->field[n].name) == 0)
            row->value[n++] = plain_value(&info->fields[i], payload);
    }
}

/* Its block records: what was given comes back, or the replay is none. */
static void take_block(struct listening *l, const struct mr_block *block)
{
    const struct golden_given *given = l->given;
    uint32_t place = block->index - given->block[0].index;
    l->near[GOLDEN_SERIAL] = (long)block->index;
    if (block->index < given->block[0].index || place >= given->blocks)
        return;
    const struct mr_block *was = &given->block[place];
    l->echoed++;
    for (unsigned i = 0; i < MR_BLOCK_SUMS && l->faithful; i++) {
        l->faithful = block->sums[i] == was->sums[i];
        if (!l->faithful)
            printf("block record %u: sum %u was given as %u, comes back as %u\n",
                   (unsigned)block->index, i + 1, was->sums[i], block->sums[i]);
    }
    if (l->faithful &&
        (memcmp(block->low_count, was->low_count, sizeof was->low_count) != 0 ||
         memcmp(block->high_count, was->high_count, sizeof was->high_count) != 0 ||
         block->absent_channels != was->absent_channels || block->tick != was->tick)) {
        l->faithful = false;
        printf(
            "block record %u: tick, fitted channels or saturation come back otherwise than given\n",
            (unsigned)block->index);
    }
}

static void listen_serial(struct listening *l, const char *path)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    struct mr_block block;
    uint8_t bytes[CHUNK];
    FILE *file = fopen(path, "rb");
    if (!file)
        golden_fail(3, "cannot read %s: %s", path, strerror(errno));
    mr_deframer_init(&deframer);
    for (size_t n; (n = fread(bytes, 1, sizeof bytes, file)) > 0;) {
        for (size_t i = 0; i < n; i++) {
            if (mr_deframer_push(&deframer, bytes[i], &frame) != MR_OK)
                continue;
            if (frame.type != MR_ID_BLOCK)
                take_message(l, GOLDEN_SERIAL, frame.type, frame.payload, frame.length);
            else if (mr_block_decode(&block, frame.payload, frame.length) == MR_OK)
                take_block(l, &block);
        }
    }
    fclose(file);
}

/* candump -L: (0000000000.017209) can0 1F0#0400000100002300 */
static void listen_can(struct listening *l, const char *path)
{
    char line[LINE], digits[2 * MR_MESSAGE_BYTES_MAX + 1];
    unsigned id;
    FILE *file = fopen(path, "r");
    if (!file)
        golden_fail(3, "cannot read %s: %s", path, strerror(errno));
    while (fgets(line, sizeof line, file)) {
        uint8_t payload[MR_MESSAGE_BYTES_MAX];
        unsigned byte;
        size_t n = 0;
        if (sscanf(line, "(%*[0-9.]) %*s %3x#%16[0-9A-F]", &id, digits) != 2)
            continue;
        for (; n < sizeof payload && sscanf(digits + 2 * n, "%2x", &byte) == 1; n++)
            payload[n] = (uint8_t)byte;
        take_message(l, GOLDEN_CAN, (uint16_t)id, payload, n);
    }
    fclose(file);
}

bool said_take(struct golden_said *said, const struct golden_given *given, const char *can_path,
               const char *serial_path)
{
    struct listening l = {.said = said, .given = given, .faithful = true};
    *said = (struct golden_said){0};
    listen_serial(&l, serial_path);
    listen_can(&l, can_path);
    /* the end of the landing ends them, a few early at most */
    if (l.faithful && l.echoed + 4 < given->blocks)
        printf("%zu of %zu block records came back\n", l.echoed, given->blocks);
    return l.faithful && l.echoed + 4 >= given->blocks;
}

/* ---- the golden file ---- */

/* As short as it can be and still the same number. */
static void write_value(gzFile file, double value)
{
    char text[40];
    if (isnan(value)) {
        gzprintf(file, " -");
        return;
    }
    for (int digits = 1; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    if (value == round(value) && fabs(value) < WHOLE_MAX) /* 10, not 1e+01 */
        snprintf(text, sizeof text, "%.0f", value);
    gzprintf(file, " %s", text);
}

static void write_kind(gzFile file, const struct golden_kind *kind)
{
    long at = 0;
    gzprintf(file, "message %s %s %zu %s\n", golden_link_text[kind->link], kind->name, kind->rows,
             kind->own_block ? "own" : "near");
    for (unsigned i = 0; i < kind->fields; i++) {
        gzprintf(file, "field %s", kind->field[i].name);
        write_value(file, kind->field[i].step);
        gzprintf(file, " %s\n", kind->field[i].unit);
    }
    for (size_t i = 0; i < kind->rows; i++) {
        gzprintf(file, "%ld", kind->row[i].at - at);
        at = kind->row[i].at;
        for (unsigned n = 0; n < kind->fields; n++)
            write_value(file, kind->row[i].value[n]);
        gzprintf(file, "\n");
    }
}

void said_write(const struct golden_said *said, const char *path)
{
    gzFile file = gzopen(path, "wb9");
    if (!file)
        golden_fail(3, "cannot write %s: %s", path, strerror(errno));
    gzprintf(file, "matrig-golden-said 1\n");
    for (size_t i = 0; i < said->kinds; i++)
        write_kind(file, &said->kind[i]);
    gzprintf(file, "end\n");
    if (gzclose(file) != Z_OK)
        golden_fail(3, "cannot write %s: is there room?", path);
}

static void read_rows(struct golden_kind *kind, size_t rows, gzFile file, char *line,
                      const char *path)
{
    long at = 0;
    kind->row = calloc(rows ? rows : 1, sizeof *kind->row);
    if (!kind->row)
        golden_fail(3, "no memory");
    for (; kind->rows < rows; kind->rows++) {
        char *text = line;
        if (!gzgets(file, line, LINE) || !strchr(line, '\n'))
            golden_fail(4, "%s ends among the rows of %s", path, kind->name);
        kind->row[kind->rows].at = at += strtol(text, &text, 10);
        for (unsigned n = 0; n < kind->fields; n++) {
            text += strspn(text, " ");
            bool missing = text[0] == '-' && (text[1] == ' ' || text[1] == '\n');
            kind->row[kind->rows].value[n] = missing ? (text++, (double)NAN) : strtod(text, &text);
        }
        if (*text != '\n')
            golden_fail(4, "%s: %s: %s", path, kind->name, line);
    }
}

static void read_kind(struct golden_said *said, gzFile file, char *line, const char *path)
{
    struct golden_kind kind = {0};
    char link[10], own[10];
    size_t rows;
    if (sscanf(line, "message %9s %47s %zu %9s", link, kind.name, &rows, own) != 4)
        golden_fail(4, "%s: %s", path, line);
    kind.link = strcmp(link, "CAN") == 0 ? GOLDEN_CAN : GOLDEN_SERIAL;
    kind.own_block = strcmp(own, "own") == 0;
    while (kind.fields < GOLDEN_FIELDS) {
        struct golden_field *field = &kind.field[kind.fields];
        int c = gzgetc(file);
        gzungetc(c, file);
        if (c != 'f')
            break;
        int length = 0;
        if (!gzgets(file, line, LINE) ||
            sscanf(line, "field %47s %lf%n", field->name, &field->step, &length) != 2)
            golden_fail(4, "%s: %s", path, line);
        snprintf(field->unit, sizeof field->unit, "%.*s", (int)strcspn(line + length + 1, "\n"),
                 line + length + 1);
        kind.fields++;
    }
    read_rows(&kind, rows, file, line, path);
    said->kind = golden_grow(said->kind, said->kinds, sizeof kind);
    said->kind[said->kinds++] = kind;
}

void said_read(struct golden_said *said, const char *path)
{
    char line[LINE];
    gzFile file = gzopen(path, "rb");
    *said = (struct golden_said){0};
    if (!file || !gzgets(file, line, sizeof line) || strcmp(line, "matrig-golden-said 1\n") != 0)
        golden_fail(file ? 4 : 3, "not a file of what a golden landing said: %s", path);
    while (gzgets(file, line, sizeof line) && strcmp(line, "end\n") != 0)
        read_kind(said, file, line, path);
    if (strcmp(line, "end\n") != 0)
        golden_fail(4, "%s ends early", path);
    gzclose(file);
}
