/* Bundles that were damaged, checked as `matrig replay BUNDLE --verify` checks. The bytes are a row
 * of patches (place, 3 bytes; count; bytes) of a small bundle that is made here; when the first
 * byte is 0xff, what follows is the whole file, and when it is 0xfe the next three say where the
 * bundle is cut off. No damage may be taken for none. */
#include <stdlib.h>
#include <string.h>

#include "host/bundle/bundle.h"
#include "host/bundle/show.h"
#include "host/link/link.h"
#include "tests/fuzz/fuzz.h"

static uint8_t *base, *patched;
static size_t base_size;

static void make_landing(struct store *store)
{
    struct error error = {0};
    struct store_session session = {.started_us = 1, .serial_link = "file:fuzz"};
    FUZZ_REQUIRE(store_begin(store, &error) == MR_OK &&
                 store_session_add(store, &session, &error) == MR_OK);
    struct store_landing landing = {.session = session.id,
                                    .board_landing = 5,
                                    .armed_us = 1,
                                    .image_crc = STORE_NONE,
                                    .config_crc = STORE_NONE};
    FUZZ_REQUIRE(store_landing_add(store, &landing, &error) == MR_OK);
    for (uint32_t i = 0; i < 100; i++) {
        uint8_t bytes[30] = {(uint8_t)i};
        const struct store_frame frame = {
            .run = landing.id, .board_us = i, .host_us = i, .id = 0x10, .length = 8, .data = bytes};
        FUZZ_REQUIRE(store_frame_put(store, session.id, &frame, &error) == MR_OK);
        FUZZ_REQUIRE(store_block_put(store, session.id, 0, landing.id, LINK_SERIAL, i, i, bytes,
                                     sizeof bytes, &error) == MR_OK);
    }
    FUZZ_REQUIRE(store_commit(store, &error) == MR_OK);
}

static void make_base(void)
{
    static const char scene[] =
        "{\"nothing\": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}";
    struct error error = {0};
    struct store *store = NULL;
    struct bundle_made made;
    char path[200];
    const struct bundle_want want = {
        .elf = "none", .scene = fuzz_file("scene.json", (const uint8_t *)scene, sizeof scene - 1)};
    snprintf(path, sizeof path, "%s.bundle", want.scene);
    FUZZ_REQUIRE(store_open(":memory:", STORE_CREATE, &store, &error) == MR_OK);
    make_landing(store);
    FUZZ_REQUIRE(bundle_make(store, 1, &want, path, &made, &error) == MR_OK);
    store_close(store);
    base = malloc(base_size = made.bytes);
    patched = malloc(base_size);
    FILE *file = fopen(path, "rb");
    FUZZ_REQUIRE(base && patched && file && fread(base, 1, base_size, file) == base_size);
    fclose(file);
    remove(path);
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

static void check(const uint8_t *bytes, size_t size)
{
    static struct bundle_check check;
    struct error error = {0};
    struct bundle *bundle = NULL;
    char verdict[450];
    bool same = size == base_size && memcmp(bytes, base, size) == 0;
    enum mr_status status = bundle_open_bytes("fuzz", bytes, size, &bundle, &check, &error);
    FUZZ_REQUIRE(status == MR_OK ? bundle != NULL : error.text[0] && !bundle);
    if (status == MR_OK) {
        bundle_verdict(&check, verdict, sizeof verdict);
        FUZZ_REQUIRE(verdict[0]);
        struct answer *answer = answer_new(false);
        bundle_answer(&check, NULL, answer);
        json_decref(answer_json(answer));
        answer_free(answer);
    }
    FUZZ_REQUIRE(same == (status == MR_OK && bundle_sound(&check) && check.sealed));
    bundle_close(bundle);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!base)
        make_base();
    if (size && data[0] == 0xff) {
        check(data + 1, size - 1);
    } else if (size > 3 && data[0] == 0xfe) {
        patch(data + 4, size - 4);
        check(patched, (data[1] | (size_t)data[2] << 8 | (size_t)data[3] << 16) % (base_size + 1));
    } else {
        patch(data, size);
        check(patched, base_size);
    }
    return 0;
}
