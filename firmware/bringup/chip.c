/* Who the chip is (RM0090 38.6.1, 39), which image it runs, why it started; its option bytes
 * (3.6.1). The F407 does not tell its package: it stands on it. */
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

/* Half-words beside their complements. */
#define OPTIONS_LOW      (*(reg32 *)0x1fffc000u)
#define OPTIONS_HIGH     (*(reg32 *)0x1fffc008u)
#define FLASH_SIZE_WORD  (*(reg32 *)0x1fff7a20u) /* KiB in the upper half: address ...22 */
#define OPTCR_WDG_SW     (1u << 5)
#define OPTCR_NRST_STOP  (1u << 6)
#define OPTCR_NRST_STDBY (1u << 7)

static const char *clock_word(uint8_t source)
{
    return source == BOARD_CLOCK_CRYSTAL  ? "crystal"
         : source == BOARD_CLOCK_INTERNAL ? "internal_pll"
                                          : "internal";
}

static const char *image_word(uint8_t state)
{
    return state == MR_IMAGE_GOOD ? "good" : state == MR_IMAGE_NONE ? "none" : "damaged";
}

static void hex_digits(char *out, uint32_t value)
{
    for (unsigned i = 0; i < 8; i++)
        out[i] = "0123456789ABCDEF"[value >> (28u - 4u * i) & 15u];
}

void bringup_identity(void)
{
    struct board_identity identity;
    char digits[25] = "";
    board_identify(&identity);
    for (unsigned i = 0; i < 3; i++)
        hex_digits(digits + 8u * i, identity.uid[i]);
    say_word("uid", digits, "id");
    say_word("board", mr_board_of(identity.board)->name, "name");
    say_hex("image_crc", identity.image_crc, "crc");
    say_word("image", image_word(identity.image_state), "state");
}

void bringup_chip(void)
{
    struct board_identity identity;
    board_identify(&identity);
    say_hex("chip", DBGMCU_IDCODE & 0xfffu, "id");
    say_hex("revision", DBGMCU_IDCODE >> 16, "id");
    /* ES0182: of revision A of the F405 and F407 it does not */
    bool broken = (DBGMCU_IDCODE & 0xfffu) == 0x413u && DBGMCU_IDCODE >> 16 == 0x1000u;
    say_word("prefetch", broken ? "broken" : "works", "state");
    say_hex("core", SCB_CPUID, "id");
    say_none("package", "id");
    say_number("flash", (int32_t)(FLASH_SIZE_WORD >> 16), "KiB");
    say_hex("reset_cause", identity.reset_cause, "bits");
    say_word("clock", clock_word(identity.clock_source), "source");
}

static bool agrees(uint32_t word, uint32_t register_half, uint32_t mask)
{
    uint32_t half = word & 0xffffu;
    return (half ^ word >> 16) == 0xffffu && (half & mask) == (register_half & mask);
}

void bringup_options(void)
{
    uint32_t optcr = FLASH_OPTCR;
    bool same = agrees(OPTIONS_LOW, optcr, 0xffecu) && agrees(OPTIONS_HIGH, optcr >> 16, 0xfffu);
    say_hex("read_protection", optcr >> 8 & 0xffu, "byte");
    say_number("brown_out", (int32_t)(3u - (optcr >> 2 & 3u)), "level");
    say_word("watchdog_option", optcr & OPTCR_WDG_SW ? "software" : "hardware", "start");
    say_number("stop_resets", !(optcr & OPTCR_NRST_STOP) + !(optcr & OPTCR_NRST_STDBY), "modes");
    /* of 512 KiB the other bits are reserved; RM0390 3.8.7 */
    uint32_t sectors = FLASH_SIZE_WORD >> 16 > 512u ? 0xfffu : 0xffu;
    say_hex("write_protected", ~(optcr >> 16) & sectors, "sectors");
    say_word("options_stored", same ? "as_loaded" : "differ", "state");
}
