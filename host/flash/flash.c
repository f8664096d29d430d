#include "host/flash/flash.h"

#include <string.h>

#define PAGE         BOOTROM_PAGE
#define PAGES        (IMAGEFILE_BYTES / PAGE)
#define SECTOR_TRIES 3u

/* Vectors and code for sector 0 while the program is not whole: from any reset to the boot ROM,
 * with its stack pointer and entry from 0x1FFF0000 (AN2606), as firmware/f407/rom.c goes there.
 *     ldr r0, =0x1fff0000;  ldr r1, [r0];  msr msp, r1;  ldr r1, [r0, #4];  bx r1 */
static const uint8_t detour[24] = {
    0x00, 0x20, 0x00, 0x20, 0x09, 0x00, 0x00, 0x08, 0x02, 0x48, 0x01, 0x68,
    0x81, 0xf3, 0x08, 0x88, 0x41, 0x68, 0x08, 0x47, 0x00, 0x00, 0xff, 0x1f,
};

enum page_state { PAGE_NONE, PAGE_EQUAL, PAGE_BLANK, PAGE_DIFFERENT };

struct job {
    struct bootrom *rom;
    const struct imagefile *image;
    const struct flash_options *options;
    struct flash_result *result;
    struct error *error;
    uint8_t page[PAGES];             /* enum page_state, by what was read */
    uint16_t from[PAGES], to[PAGES]; /* the image's part of it */
    unsigned done, of;               /* of the phase */
};

static void begin_phase(struct job *job, unsigned of)
{
    job->done = 0;
    job->of = of;
}

static void step(struct job *job, enum flash_phase phase)
{
    if (job->options->progress)
        job->options->progress(job->options->context, phase, ++job->done, job->of);
}

/* From the first to the last byte of a page that the image gives, on whole words. */
static void find_extent(struct job *job, uint32_t page)
{
    const uint8_t *given = job->image->given + page * PAGE;
    unsigned last = PAGE;
    const uint8_t *first = memchr(given, 1, PAGE);
    if (!first)
        return;
    while (!given[last - 1])
        last--;
    job->from[page] = (uint16_t)((first - given) & ~3);
    job->to[page] = (uint16_t)((last + 3u) & ~3u);
}

/* [*from, *to) of flash. False: the image gives nothing there. */
static bool extent(const struct job *job, uint32_t page, uint32_t *from, uint32_t *to)
{
    *from = page * PAGE + job->from[page];
    *to = page * PAGE + job->to[page];
    return job->to[page] > 0;
}

static enum page_state judge(const struct imagefile *image, uint32_t from, uint32_t to,
                             const uint8_t *bytes)
{
    bool equal = true, blank = true;
    for (uint32_t i = from; i < to; i++) {
        equal = equal && (!image->given[i] || bytes[i - from] == image->bytes[i]);
        blank = blank && bytes[i - from] == 0xff;
    }
    return equal ? PAGE_EQUAL : blank ? PAGE_BLANK : PAGE_DIFFERENT;
}

static enum mr_status read_page(struct job *job, uint32_t page, enum page_state *state)
{
    uint8_t bytes[PAGE];
    uint32_t from, to;
    *state = PAGE_NONE;
    if (!extent(job, page, &from, &to))
        return MR_OK;
    enum mr_status status = bootrom_read(job->rom, MR_IMAGE_FLASH + from, bytes, to - from,
                                         job->error);
    if (status == MR_OK)
        *state = judge(job->image, from, to, bytes);
    return status;
}

static uint32_t first_page(unsigned sector)
{
    return sector_start(sector) / PAGE;
}
static uint32_t end_page(unsigned sector)
{
    return sector_end(sector) / PAGE;
}

static bool any(const struct job *job, unsigned sector, enum page_state state)
{
    return memchr(job->page + first_page(sector), (int)state,
                  end_page(sector) - first_page(sector)) != NULL;
}

static bool needs_erase(const struct job *job, unsigned sector)
{
    return any(job, sector, PAGE_DIFFERENT);
}

static bool needs_work(const struct job *job, unsigned sector)
{
    return needs_erase(job, sector) || any(job, sector, PAGE_BLANK);
}

/* What is there? A sector is read up to the first page that makes it be erased. */
static enum mr_status compare(struct job *job)
{
    uint32_t from, to;
    enum mr_status status = MR_OK;
    for (uint32_t page = 0; page < PAGES; page++) {
        find_extent(job, page);
        job->result->pages += extent(job, page, &from, &to);
    }
    begin_phase(job, job->result->pages);
    for (unsigned sector = 0; status == MR_OK && sector < SECTORS; sector++) {
        bool different = job->options->all;
        for (uint32_t page = first_page(sector); status == MR_OK && page < end_page(sector);
             page++) {
            enum page_state state = PAGE_NONE;
            if (!extent(job, page, &from, &to))
                continue;
            if (different)
                state = PAGE_DIFFERENT;
            else
                status = read_page(job, page, &state);
            if (status == MR_OK && state == PAGE_DIFFERENT && !different) /* or was it the line? */
                status = read_page(job, page, &state);
            different = state == PAGE_DIFFERENT;
            job->page[page] = (uint8_t)state;
            step(job, FLASH_COMPARING);
        }
    }
    return status;
}

static void mark(struct job *job, unsigned sector, enum page_state state)
{
    for (uint32_t page = first_page(sector); page < end_page(sector); page++) {
        if (job->page[page] != PAGE_NONE)
            job->page[page] = (uint8_t)state;
    }
}

static enum mr_status erase(struct job *job, unsigned sector)
{
    enum mr_status status = bootrom_erase(job->rom, sector, job->error);
    if (status == MR_OK) {
        job->result->erased |= 1u << sector;
        mark(job, sector, PAGE_BLANK);
    }
    return status;
}

/* MR_WAIT: the sector must be erased first. */
static enum mr_status write_page(struct job *job, uint32_t page)
{
    uint32_t from, to;
    if (!extent(job, page, &from, &to))
        return MR_OK;
    enum mr_status status = bootrom_write(job->rom, MR_IMAGE_FLASH + from, job->image->bytes + from,
                                          to - from, job->error);
    if (status == MR_OK) {
        job->page[page] = PAGE_EQUAL;
        job->result->written++;
        step(job, FLASH_WRITING);
    }
    return status;
}

/* The first page last: it has the vectors. */
static enum mr_status write_blank_pages(struct job *job, unsigned sector)
{
    enum mr_status status = MR_OK;
    for (uint32_t page = end_page(sector); status == MR_OK && page-- > first_page(sector);) {
        if (job->page[page] == PAGE_BLANK)
            status = write_page(job, page);
    }
    return status;
}

/* Did erasing do anything? A sector protected against writing keeps what it has, and the ROM does
 * not say so. */
static enum mr_status check_erased(struct job *job, unsigned sector, uint32_t page)
{
    uint8_t bytes[PAGE];
    uint32_t from, to;
    enum page_state state;
    (void)extent(job, page, &from, &to);
    enum mr_status status = bootrom_read(job->rom, MR_IMAGE_FLASH + from, bytes, to - from,
                                         job->error);
    if (status != MR_OK)
        return status;
    state = judge(job->image, from, to, bytes);
    if (state == PAGE_DIFFERENT && read_page(job, page, &state) == MR_OK && state == PAGE_DIFFERENT)
        return error_set(job->error, MR_NOT_NOW,
                         "sector %u (0x%08x) does not erase: %s; is it write-protected? stm32flash "
                         "-u lifts that",
                         sector, (unsigned)(MR_IMAGE_FLASH + sector_start(sector)),
                         job->rom->line->name);
    return job->error->status;
}

static enum mr_status work_on(struct job *job, unsigned sector)
{
    enum mr_status status = MR_WAIT;
    for (unsigned try = 0; status == MR_WAIT && try < SECTOR_TRIES; try++) {
        status = MR_OK;
        if (try > 0 || needs_erase(job, sector)) {
            uint32_t page = first_page(sector);
            while (page + 1 < end_page(sector) && job->page[page] != PAGE_DIFFERENT)
                page++;
            status = erase(job, sector);
            if (status == MR_OK && job->page[page] != PAGE_NONE)
                status = check_erased(job, sector, page);
        }
        if (status == MR_OK)
            status = write_blank_pages(job, sector);
    }
    if (status == MR_WAIT)
        return error_set(job->error, MR_LIMIT,
                         "sector %u (0x%08x) does not keep what is written, %u tries: %s; the "
                         "flash is worn or the "
                         "supply too low",
                         sector, (unsigned)(MR_IMAGE_FLASH + sector_start(sector)), SECTOR_TRIES,
                         job->rom->line->name);
    return status;
}

/* Read back. What differs is read again: it may have been the line. */
static enum mr_status verify_page(struct job *job, uint32_t page)
{
    uint8_t bytes[PAGE];
    uint32_t from, to, at;
    if (!extent(job, page, &from, &to))
        return MR_OK;
    enum mr_status status = MR_OK;
    for (unsigned try = 0; try < BOOTROM_TRIES; try++) {
        status = bootrom_read(job->rom, MR_IMAGE_FLASH + from, bytes, to - from, job->error);
        if (status != MR_OK)
            return status;
        for (at = from;
             at < to && (!job->image->given[at] || bytes[at - from] == job->image->bytes[at]);
             at++) {
        }
        if (at == to) {
            for (uint32_t i = from; i < to; i++)
                job->result->verified += job->image->given[i];
            job->result->reread += try > 0;
            step(job, FLASH_VERIFYING);
            return MR_OK;
        }
    }
    return error_set(job->error, MR_LIMIT,
                     "not what was written: 0x%08x holds 0x%02x, the image has 0x%02x: %s; run it "
                     "again, with --all",
                     (unsigned)(MR_IMAGE_FLASH + at), bytes[at - from], job->image->bytes[at],
                     job->rom->line->name);
}

static enum mr_status verify(struct job *job, unsigned first_sector, unsigned end_sector)
{
    enum mr_status status = MR_OK;
    for (uint32_t page = first_page(first_sector);
         status == MR_OK && page < end_page(end_sector - 1); page++)
        status = verify_page(job, page);
    return status;
}

/* MR_OK: it is there; MR_WAIT: it is not. */
static enum mr_status look_for_detour(struct job *job)
{
    uint8_t bytes[sizeof detour];
    enum mr_status status = bootrom_read(job->rom, MR_IMAGE_FLASH, bytes, sizeof bytes, job->error);
    return status == MR_OK && memcmp(bytes, detour, sizeof detour) != 0 ? MR_WAIT : status;
}

/* Sector 0 to the boot ROM, unless an earlier run has done so. */
static enum mr_status set_detour(struct job *job)
{
    enum mr_status status = look_for_detour(job);
    job->result->resumed |= status == MR_OK;
    for (unsigned try = 0; status == MR_WAIT && try < SECTOR_TRIES; try++) {
        status = erase(job, 0);
        if (status == MR_OK)
            status = bootrom_write(job->rom, MR_IMAGE_FLASH, detour, sizeof detour, job->error);
        if (status == MR_OK)
            status = look_for_detour(job);
    }
    if (status == MR_WAIT)
        return error_set(
            job->error, MR_LIMIT,
            "sector 0 (0x%08x) does not keep what is written: %s; is it write-protected?",
            MR_IMAGE_FLASH, job->rom->line->name);
    mark(job, 0, PAGE_DIFFERENT);
    return status;
}

static enum mr_status erase_configuration(struct job *job)
{
    enum mr_status status = MR_OK;
    for (unsigned sector = SECTOR_CONFIGURATION;
         status == MR_OK && sector < SECTOR_CONFIGURATION + 2; sector++)
        status = erase(job, sector);
    return status;
}

static unsigned pages_left(const struct job *job)
{
    unsigned left = 0;
    for (unsigned sector = 0; sector < SECTORS; sector++) {
        bool whole = needs_erase(job, sector);
        for (uint32_t page = first_page(sector); page < end_page(sector); page++)
            left += whole ? job->page[page] != PAGE_NONE : job->page[page] == PAGE_BLANK;
    }
    return left;
}

/* Half a program, which an earlier run left: some pages there, the rest blank. */
static bool half_there(const struct job *job)
{
    bool half = false;
    for (unsigned sector = 1; sector < SECTORS; sector++)
        half = half || (any(job, sector, PAGE_EQUAL) && any(job, sector, PAGE_BLANK) &&
                        !needs_erase(job, sector));
    return half;
}

enum mr_status flash_run(struct bootrom *rom, const struct imagefile *image,
                         const struct flash_options *options, struct flash_result *result,
                         struct error *error)
{
    struct job job = {
        .rom = rom, .image = image, .options = options, .result = result, .error = error};
    bool others = false;
    *result = (struct flash_result){0};
    enum mr_status status = compare(&job);
    for (unsigned sector = 1; sector < SECTORS; sector++)
        others = others || (needs_work(&job, sector));
    if (others) /* sector 0 is another's place until they are whole */
        mark(&job, 0, PAGE_DIFFERENT);
    if (status == MR_OK) {
        unsigned left = pages_left(&job);
        result->kept = result->pages - left;
        result->resumed = half_there(&job);
        begin_phase(&job, left);
    }
    if (status == MR_OK && others)
        status = set_detour(&job);
    if (status == MR_OK && options->erase_configuration)
        status = erase_configuration(&job);
    for (unsigned sector = 1; status == MR_OK && sector < SECTORS; sector++) {
        if (needs_work(&job, sector))
            status = work_on(&job, sector);
    }
    unsigned writing_done = job.done, writing_of = job.of;
    begin_phase(&job, result->pages);
    if (status == MR_OK)
        status = verify(&job, 1, SECTORS);
    unsigned verifying_done = job.done;
    job.done = writing_done;
    job.of = writing_of;
    if (status == MR_OK && needs_work(&job, 0))
        status = work_on(&job, 0);
    begin_phase(&job, result->pages);
    job.done = verifying_done;
    return status == MR_OK ? verify(&job, 0, 1) : status;
}
