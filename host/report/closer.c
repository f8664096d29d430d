#include "host/report/closer.h"

#include <sha2.h>

#include "host/base/html.h"

/* module.mk puts it where the assembler finds it, and makes this file anew when it changes. */
__asm__(".section .rodata\n"
        "report_closer:\n.incbin \"closer.js\"\n"
        "report_closer_end:\n.byte 0\n.previous\n");
/* Hidden: of this program. By way of the table of global offsets both would be the section's begin
 * on 64-bit ARM, where entries of that table take no addend. */
extern const char report_closer[] __attribute__((visibility("hidden"))),
    report_closer_end[] __attribute__((visibility("hidden")));

void closer_policy(FILE *out)
{
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Init(&hash);
    SHA256Update(&hash, (const uint8_t *)report_closer,
                 (size_t)(report_closer_end - report_closer));
    SHA256Final(sum, &hash);
    fputs(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
        "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; script-src 'sha256-",
        out);
    html_base64(out, sum, sizeof sum);
    fputs("'\">", out);
}

void closer_write(FILE *out)
{
    fputs("<script>", out);
    fwrite(report_closer, 1, (size_t)(report_closer_end - report_closer), out);
    fputs("</script>\n", out);
}
