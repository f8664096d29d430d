/* Campaign databases that were damaged, read as `matrig report` reads. The bytes are a row of
 * patches (place, 3 bytes; count; bytes) of a small campaign that is made here; when the first byte
 * is 0xff, what follows is the whole file. */
#include <stdlib.h>
#include <string.h>

#include "common/framing.h"
#include "host/collect/collect.h"
#include "host/base/xmalloc.h"
#include "host/report/report.h"
#include "tests/fuzz/fuzz.h"

#define LANDINGS_MAX 3u /* damage can make any number of them */

static uint8_t *base, *patched;
static size_t base_size;

static void give(struct collector *collector, uint16_t id, const uint8_t *payload, size_t length)
{
    static uint16_t seq;
    static uint64_t now_us = 1700000000000000u;
    struct error error = {0};
    uint8_t bytes[MR_FRAME_BYTES_MAX];
    size_t count = mr_frame_encode(seq++, id, payload, length, bytes);
    FUZZ_REQUIRE(collector_receive_bytes(collector, bytes, count, now_us += 1000, &error) == MR_OK);
}

/* A landing of a few blocks, with each message of the catalogue once. */
static void log_landing(struct collector *collector)
{
    uint8_t payload[MR_FRAME_PAYLOAD_BYTES_MAX];
    const struct mr_hello hello = {.layout = MR_LAYOUT, .major = 1};
    give(collector, MR_ID_HELLO, payload, mr_hello_put(&hello, payload));
    const struct mr_landing armed = {.state = 1, .landing = 7};
    give(collector, MR_ID_LANDING, payload, mr_landing_put(&armed, payload));
    for (uint32_t i = 0; i < 20; i++) {
        struct mr_block block = {.index = i};
        give(collector, MR_ID_BLOCK, payload, mr_block_encode(&block, payload));
    }
    size_t count;
    const struct mr_message_info *catalogue = mr_catalogue_messages(&count);
    memset(payload, 0, sizeof payload);
    for (size_t i = 0; i < count; i++) {
        if (catalogue[i].id != MR_ID_HELLO && catalogue[i].id != MR_ID_LANDING &&
            catalogue[i].length <= 8)
            give(collector, catalogue[i].id, payload, catalogue[i].length);
    }
}

static void make_base(void)
{
    struct error error = {0};
    struct store *store = NULL;
    struct collector *collector = NULL;
    char path[200];
    snprintf(path, sizeof path, "%s", fuzz_file("campaign.db", NULL, 0));
    remove(path);
    FUZZ_REQUIRE(store_open(path, STORE_CREATE, &store, &error) == MR_OK &&
                 store_begin(store, &error) == MR_OK);
    FUZZ_REQUIRE(collector_open(store, NULL, 0, "serial:fuzz", &collector, &error) == MR_OK);
    log_landing(collector);
    FUZZ_REQUIRE(collector_end(collector, "end", &error) == MR_OK &&
                 store_commit(store, &error) == MR_OK);
    collector_close(collector);
    store_close(store);
    FILE *file = fopen(path, "rb");
    FUZZ_REQUIRE(file && fseek(file, 0, SEEK_END) == 0);
    base_size = (size_t)ftell(file);
    rewind(file);
    base = malloc(base_size);
    patched = malloc(base_size);
    FUZZ_REQUIRE(base && patched && fread(base, 1, base_size, file) == base_size);
    fclose(file);
}

static void patch(const uint8_t *data, size_t size)
{
    memcpy(patched, base, base_size);
    while (size > 4) {
        size_t at = (data[0] | (size_t)data[1] << 8 | (size_t)data[2] << 16) % base_size,
               count = data[3] % 32u;
        data += 4;
        size -= 4;
        for (; count && size; count--, size--, at = (at + 1) % base_size)
            patched[at] = *data++;
    }
}

/* A page in memory: nothing of it may be an element that the page has not by itself. */
static enum mr_status make_page(const char *path, struct store *store, struct error *error)
{
    struct report report = {.path = path, .store = store};
    char *text = NULL;
    size_t length = 0;
    enum mr_status status = report_begin(&report, true, error);
    FILE *out = xopen_memstream(&text, &length);
    if (status == MR_OK)
        status = report_write_page(&report, out, error);
    fclose(out);
    static const char data[] = "<script type=\"application/json\">{";
    size_t scripts = 0; /* beside data, its own and no other */
    for (const char *s = text; (s = strstr(s, "<script")) != NULL; s++)
        scripts += strncmp(s, data, sizeof data - 1) != 0;
    FUZZ_REQUIRE(scripts <= 1);
    free(text);
    report_free(&report);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct error error = {0};
    struct store *store = NULL;
    struct store_landing *landing = NULL;
    size_t count = 0;
    const char *path;
    if (!base)
        make_base();
    if (size && data[0] == 0xff) {
        path = fuzz_file("campaign.db", data + 1, size - 1);
    } else {
        patch(data, size);
        path = fuzz_file("campaign.db", patched, base_size);
    }
    enum mr_status status = store_open(path, STORE_READ, &store, &error);
    if (status == MR_OK)
        status = store_landings_get(store, &landing, &count, &error);
    if (status == MR_OK && count <= LANDINGS_MAX)
        status = make_page(path, store, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
    free(landing);
    store_close(store);
    return 0;
}
