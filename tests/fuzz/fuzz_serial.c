/* Serial bytes and CAN frames of a board into a campaign: whatever they say, the collector goes on
 * or refuses, and the campaign stays whole. The first byte chooses: even, bytes as they are; odd, a
 * row of messages (place in the catalogue, link, length, payload), framed with the right CRC after
 * a hello of the right layout, as no random bytes would be. */
#include <string.h>

#include "common/framing.h"
#include "host/collect/collect.h"
#include "tests/fuzz/fuzz.h"

static struct collector *collector;
static uint64_t now_us;

static void give(uint16_t id, bool can, const uint8_t *payload, size_t length)
{
    static uint16_t seq;
    struct error error = {0};
    uint8_t bytes[MR_FRAME_BYTES_MAX];
    now_us += 700;
    if (can) {
        struct link_frame frame = {
            .host_us = now_us, .id = id & 0x7ffu, .length = (uint8_t)(length > 8 ? 8 : length)};
        memcpy(frame.data, payload, frame.length);
        (void)collector_receive_frame(collector, &frame, &error);
        return;
    }
    size_t count = mr_frame_encode(seq++, id, payload, length, bytes);
    (void)collector_receive_bytes(collector, bytes, count, now_us, &error);
}

static void give_messages(const uint8_t *data, size_t size)
{
    size_t count;
    const struct mr_message_info *catalogue = mr_catalogue_messages(&count);
    const struct mr_hello hello = {.layout = MR_LAYOUT, .major = 1};
    uint8_t payload[MR_FRAME_PAYLOAD_BYTES_MAX];
    size_t length = mr_hello_put(&hello, payload);
    give(MR_ID_HELLO, false, payload, length);
    give(MR_ID_HELLO, true, payload, length);
    while (size >= 3) {
        size_t place = data[0] % (count + 2u);
        uint16_t id = place < count  ? catalogue[place].id
                    : place == count ? MR_ID_BLOCK
                                     : MR_ID_BOX_PART;
        length = data[2] % (MR_FRAME_PAYLOAD_BYTES_MAX + 1u);
        if (length > size - 3)
            length = size - 3;
        give(id, data[1] & 1u, data + 3, length);
        data += 3 + length;
        size -= 3 + length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct error error = {0};
    if (size < 1 || size > 4096)
        return 0;
    now_us = 1000000;
    struct store *store = fuzz_store();
    FUZZ_REQUIRE(collector_open(store, "can:fuzz", 0, "serial:fuzz", &collector, &error) == MR_OK);
    if (data[0] & 1u)
        give_messages(data + 1, size - 1);
    else
        (void)collector_receive_bytes(collector, data + 1, size - 1, now_us, &error);
    (void)collector_end_link(collector, LINK_SERIAL, &error);
    FUZZ_REQUIRE(collector_end(collector, "end", &error) == MR_OK);
    collector_close(collector);
    return 0;
}
