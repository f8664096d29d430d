/* Packets of the GDB remote serial protocol over a connection: `$text#sum`, acknowledged by `+`
 * (GDB manual, E.1). For gdb.c. */
#ifndef MATRIG_HIL_GDB_PACKET_H
#define MATRIG_HIL_GDB_PACKET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hil/core/call.h"

#define HIL_GDB_PACKET 4096u

struct hil_gdb_line {
    int fd; /* -1: none */
    bool acknowledges;
    char in[2 * HIL_GDB_PACKET];
    size_t in_size;
    struct hil_call lost; /* the connection is over */
};

/* Bytes of hex text, at most `room`: how many. And the other way, with a 0 after them: where that 0
 * is. */
size_t hil_gdb_from_hex(const char *text, uint8_t *bytes, size_t room);
char *hil_gdb_to_hex(char *text, const void *bytes, size_t n);

/* End the connection; whoever `lost` names is told. */
void hil_gdb_lose(struct hil_gdb_line *line);
/* Send; waits ten seconds at most, then the connection is lost. */
void hil_gdb_put_packet(struct hil_gdb_line *line, const char *text);
/* A line for the debugger's console; only while the debugger waits for the board or for a monitor
 * command. */
void hil_gdb_put_console(struct hil_gdb_line *line, const char *text);
/* What the socket has, up to timeout_ms; false: it is closed. */
bool hil_gdb_receive(struct hil_gdb_line *line, int timeout_ms);
/* The next whole packet in the buffer, unescaped, with a 0 after it; its length, or -1: none.
 * *interrupt: Ctrl-C came instead. A packet whose sender cannot be told that it came is none: the
 * connection is lost, and the board detached. But for kill: gdb goes as soon as it has sent it. */
int hil_gdb_take_packet(struct hil_gdb_line *line, char *packet, bool *interrupt);

#endif
