#include "hil/debug/gdb.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hil/board/board.h"
#include "hil/core/wall.h"
#include "hil/link/wire_link.h"

#define POLL_INTERVAL_MS  50
#define SEND_TIMEOUT_MS   10000
/* number of bytes of memory whose hex digits fit into one answer */
#define MEMORY_ANSWER_MAX (HIL_GDB_PACKET_MAX / 2u - 8u)
#define SIGNAL_INTERRUPT  2
#define SIGNAL_TRAP       5
#define SIGNAL_SEGV       11

/* Registers in the order of enum hil_debug_register. */

/* clang-format off */
#define REG(name, ...)    "<reg name=\"" name "\" bitsize=\"32\"" __VA_ARGS__ "/>\n"
#define REG_D(n)          "<reg name=\"d" #n "\" bitsize=\"64\" type=\"ieee_double\"/>\n"
#define FEATURE(name, of) "<feature name=\"org.gnu.gdb.arm." name "\">\n" of "</feature>\n"
static const char target_xml[] =
    "<?xml version=\"1.0\"?>\n<!DOCTYPE target SYSTEM \"gdb-target.dtd\">\n"
    "<target version=\"1.0\">\n<architecture>armv7e-m</architecture>\n"
    FEATURE("m-profile",
        REG("r0", " regnum=\"0\"") REG("r1") REG("r2") REG("r3") REG("r4") REG("r5") REG("r6")
        REG("r7") REG("r8") REG("r9") REG("r10") REG("r11") REG("r12")
        REG("sp", " type=\"data_ptr\"") REG("lr") REG("pc", " type=\"code_ptr\"") REG("xpsr"))
    FEATURE("m-system",
        REG("msp", " type=\"data_ptr\"") REG("psp", " type=\"data_ptr\"") REG("primask")
        REG("basepri") REG("faultmask") REG("control"))
    FEATURE("vfp",
        REG_D(0) REG_D(1) REG_D(2) REG_D(3) REG_D(4) REG_D(5) REG_D(6) REG_D(7) REG_D(8)
        REG_D(9) REG_D(10) REG_D(11) REG_D(12) REG_D(13) REG_D(14) REG_D(15)
        REG("fpscr", " type=\"int\" group=\"float\""))
    "</target>\n";
#undef REG
#undef REG_D
#undef FEATURE
/* clang-format on */

/* --- packets: `$text#sum`, acknowledged by `+` (GDB manual, E.1) --- */

static int parse_hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

/* Converts hex text to at most `room` bytes and returns their number. The reverse, format_hex,
 * returns the position of the terminating 0. */
static size_t parse_hex(const char *text, uint8_t *bytes, size_t room)
{
    size_t n = 0;
    while (n < room && parse_hex_digit(text[0]) >= 0 && parse_hex_digit(text[1]) >= 0) {
        bytes[n++] = (uint8_t)(parse_hex_digit(text[0]) << 4 | parse_hex_digit(text[1]));
        text += 2;
    }
    return n;
}

static char *format_hex(char *text, const void *bytes, size_t n)
{
    static const char digits[] = "0123456789abcdef";
    const uint8_t *p = bytes;
    for (size_t i = 0; i < n; i++) {
        *text++ = digits[p[i] >> 4];
        *text++ = digits[p[i] & 15u];
    }
    *text = '\0';
    return text;
}

/* Ends the connection and reports it to `on_disconnect`. */
static void drop_connection(struct hil_gdb_connection *line)
{
    if (line->fd >= 0)
        close(line->fd);
    line->fd = -1;
    line->input_size = 0;
    hil_callback_invoke(&line->on_disconnect);
}

static void send_all(struct hil_gdb_connection *line, const char *bytes, size_t n)
{
    int64_t until = hil_wall_clock_ms() + SEND_TIMEOUT_MS;
    while (n && line->fd >= 0) {
        ssize_t sent = send(line->fd, bytes, n, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent > 0) {
            bytes += sent;
            n -= (size_t)sent;
            continue;
        }
        struct pollfd wait = {.fd = line->fd, .events = POLLOUT};
        if ((errno != EAGAIN && errno != EINTR) || hil_wall_clock_ms() > until)
            drop_connection(line);
        else
            poll(&wait, 1, POLL_INTERVAL_MS);
    }
}

/* Sends a packet. If that takes more than ten seconds, the connection is lost. */
static void send_packet(struct hil_gdb_connection *line, const char *text)
{
    char packet[2 * HIL_GDB_PACKET_MAX + 8];
    uint8_t sum = 0;
    size_t n = strlen(text);
    for (size_t i = 0; i < n; i++)
        sum = (uint8_t)(sum + (uint8_t)text[i]);
    int length = snprintf(packet, sizeof packet, "$%s#%02x", text, sum);
    send_all(line, packet, (size_t)length);
}

/* Sends a line to the debugger's console. Allowed only while gdb waits for the board or for a
 * monitor command. */
static void send_console_text(struct hil_gdb_connection *line, const char *text)
{
    char packet[2 * HIL_GDB_PACKET_MAX] = "O";
    size_t n = strlen(text);
    format_hex(packet + 1, text, n < HIL_GDB_PACKET_MAX - 2 ? n : HIL_GDB_PACKET_MAX - 2);
    send_packet(line, packet);
}

/* Reads from the socket, waiting up to timeout_ms. False: the socket is closed. */
static bool receive_input(struct hil_gdb_connection *line, int timeout_ms)
{
    struct pollfd wait = {.fd = line->fd, .events = POLLIN};
    if (line->input_size == sizeof line->input)
        line->input_size = 0; /* the input is longer than any packet: drop it */
    if (line->fd < 0 || poll(&wait, 1, timeout_ms) <= 0)
        return line->fd >= 0;
    ssize_t n = recv(line->fd, line->input + line->input_size,
                     sizeof line->input - line->input_size, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
        drop_connection(line);
        return false;
    }
    if (n > 0)
        line->input_size += (size_t)n;
    return true;
}

static void discard_input(struct hil_gdb_connection *line, size_t n)
{
    memmove(line->input, line->input + n, line->input_size - n);
    line->input_size -= n;
}

/* Removes the next whole packet from the buffer and copies it, unescaped and terminated with 0.
 * Returns its length; -1: no packet, or, if *interrupt is set, Ctrl-C. If a packet cannot be
 * acknowledged, the connection is lost and the packet is ignored, except kill, after which gdb
 * disconnects at once. */
static int extract_next_packet(struct hil_gdb_connection *line, char *packet, bool *interrupt)
{
    *interrupt = false;
    while (line->input_size && line->input[0] != '$') {
        *interrupt = line->input[0] == 3;
        discard_input(line, 1);
        if (*interrupt)
            return -1;
    }
    const char *hash = line->input_size ? memchr(line->input, '#', line->input_size) : NULL;
    if (!hash || line->input_size - (size_t)(hash - line->input) < 3)
        return -1;
    uint8_t sum = 0;
    int n = 0;
    for (const char *p = line->input + 1; p < hash; p++) {
        sum = (uint8_t)(sum + (uint8_t)*p);
        if (*p == '}' && p + 1 < hash) {
            sum = (uint8_t)(sum + (uint8_t)p[1]);
            packet[n++] = (char)(*++p ^ 0x20);
        } else {
            packet[n++] = *p;
        }
    }
    packet[n] = '\0';
    bool good = parse_hex_digit(hash[1]) >= 0 && parse_hex_digit(hash[2]) >= 0 &&
                sum == (parse_hex_digit(hash[1]) << 4 | parse_hex_digit(hash[2]));
    discard_input(line, (size_t)(hash - line->input) + 3);
    if (line->is_acknowledging)
        send_all(line, good ? "+" : "-", 1);
    return good && (line->fd >= 0 || strcmp(packet, "k") == 0) ? n : -1;
}

/* Parses `ADDRESS,LENGTH`; `rest` is the text after it. Returns false for a syntax error. */
static bool read_two_numbers(const char *text, uint32_t *a, uint32_t *b, const char **rest)
{
    char *end;
    *a = (uint32_t)strtoul(text, &end, 16);
    if (end == text || *end != ',')
        return false;
    text = end + 1;
    *b = (uint32_t)strtoul(text, &end, 16);
    *rest = end;
    return end != text;
}

/* --- registers and memory --- */

static size_t get_register_bytes(unsigned number)
{
    return number >= HIL_REG_D0 && number < HIL_REG_FPSCR ? 8 : 4;
}

static char *format_register(const struct hil_gdb *gdb, unsigned number, char *text)
{
    uint64_t value = hil_debug_read_register(gdb->board, number);
    return format_hex(text, &value, get_register_bytes(number));
}

static bool set_register(struct hil_gdb *gdb, unsigned number, const char *text)
{
    uint64_t value = 0;
    if (number >= HIL_REG_COUNT || parse_hex(text, (uint8_t *)&value, get_register_bytes(number)) !=
                                       get_register_bytes(number))
        return false;
    hil_debug_write_register(gdb->board, number, value);
    return true;
}

static void read_memory(struct hil_gdb *gdb, const char *text, char *answer)
{
    uint8_t bytes[MEMORY_ANSWER_MAX];
    uint32_t address, n;
    if (!read_two_numbers(text, &address, &n, &text) || n > MEMORY_ANSWER_MAX) {
        strcpy(answer, "E01");
        return;
    }
    if (hil_debug_read(gdb->board, address, bytes, n) == MR_OK)
        format_hex(answer, bytes, n);
    else
        strcpy(answer, "E0e"); /* EFAULT */
}

static void write_memory(struct hil_gdb *gdb, const char *text, char *answer)
{
    uint8_t bytes[HIL_GDB_PACKET_MAX];
    uint32_t address, n;
    strcpy(answer, "E01");
    if (!read_two_numbers(text, &address, &n, &text) || *text != ':' || n > sizeof bytes)
        return;
    if (parse_hex(text + 1, bytes, n) != n)
        return;
    bool done = n == 0 || hil_debug_write(gdb->board, address, bytes, n) == MR_OK;
    strcpy(answer, done ? "OK" : "E0e");
}

/* Handles the packets Z and z: kind, address, size. */
static void set_break_or_watchpoint(struct hil_gdb *gdb, const char *text, bool set, char *answer)
{
    uint32_t address, size;
    const char *rest;
    char kind = text[0];
    if (kind < '0' || kind > '4' || text[1] != ',')
        return; /* unknown kind: send the empty answer */
    if (!read_two_numbers(text + 2, &address, &size, &rest)) {
        strcpy(answer, "E01");
        return;
    }
    enum mr_status status = kind < '2' ? hil_debug_set_breakpoint(gdb->board, address, set)
                                       : hil_debug_set_watchpoint(gdb->board,
                                                                  (enum hil_watch_kind)(kind - '0'),
                                                                  address, size, set);
    strcpy(answer, status == MR_OK ? "OK" : "E1c"); /* ENOSPC */
}

static void read_target_description(const char *text, char *answer)
{
    uint32_t offset, n;
    const char *rest;
    size_t size = sizeof target_xml - 1;
    if (!read_two_numbers(text, &offset, &n, &rest)) {
        strcpy(answer, "E01");
        return;
    }
    if (n > HIL_GDB_PACKET_MAX - 8u)
        n = HIL_GDB_PACKET_MAX - 8u;
    if (offset > size)
        offset = (uint32_t)size;
    if (n > size - offset)
        n = (uint32_t)(size - offset);
    answer[0] = offset + n < size ? 'm' : 'l';
    memcpy(answer + 1, target_xml + offset, n);
    answer[1 + n] = '\0';
}

/* --- monitor --- */

static void format_time(const struct hil_board *board, char *text, size_t size)
{
    uint64_t now_ps = hil_board_now_ps(board);
    snprintf(text, size, "%llu.%09llu s virtual, cycle %llu at %u Hz, %llu instructions\n",
             (unsigned long long)(now_ps / HIL_PS_PER_S),
             (unsigned long long)(now_ps % HIL_PS_PER_S / HIL_PS_PER_NS),
             (unsigned long long)hil_now_cycle(&board->core),
             (unsigned)board->core.state.clock.hclk_hz,
             (unsigned long long)hil_board_counters(board)->instructions);
}

static void run_monitor_command(struct hil_gdb *gdb, const char *hex, char *answer)
{
    char command[128] = "", text[256];
    parse_hex(hex, (uint8_t *)command, sizeof command - 1);
    bool reset = strcmp(command, "reset") == 0;
    if (reset)
        hil_board_reset(gdb->board);
    if (reset)
        snprintf(text, sizeof text, "reset; PC 0x%08x\n",
                 (unsigned)hil_cpu_register(&gdb->board->core, 15));
    else if (strcmp(command, "time") == 0)
        format_time(gdb->board, text, sizeof text);
    else
        snprintf(text, sizeof text,
                 "time   virtual time, cycles, instructions\n"
                 "reset  reset the chip; then `maintenance flush register-cache`\n");
    format_hex(answer, text, strlen(text));
}

/* --- packets --- */

static void answer_query(struct hil_gdb *gdb, const char *packet, char *answer)
{
    if (strncmp(packet, "qSupported", 10) == 0)
        snprintf(answer, HIL_GDB_PACKET_MAX,
                 "PacketSize=%x;qXfer:features:read+;vContSupported+;QStartNoAckMode+",
                 (unsigned)HIL_GDB_PACKET_MAX);
    else if (strncmp(packet, "qXfer:features:read:target.xml:", 31) == 0)
        read_target_description(packet + 31, answer);
    else if (strcmp(packet, "qAttached") == 0)
        strcpy(answer, "1");
    else if (strcmp(packet, "qC") == 0)
        strcpy(answer, "QC1");
    else if (strcmp(packet, "qfThreadInfo") == 0)
        strcpy(answer, "m1");
    else if (strcmp(packet, "qsThreadInfo") == 0)
        strcpy(answer, "l");
    else if (strncmp(packet, "qSymbol", 7) == 0)
        strcpy(answer, "OK");
    else if (strncmp(packet, "qRcmd,", 6) == 0)
        run_monitor_command(gdb, packet + 6, answer);
}

static void report_stop(struct hil_gdb *gdb, enum mr_status status)
{
    char packet[64];
    const struct hil_debug *d = &gdb->debug;
    int signal = status != MR_OK                      ? SIGNAL_SEGV
               : d->hold_reason == HIL_HOLD_REQUESTED ? SIGNAL_INTERRUPT
                                                      : SIGNAL_TRAP;
    int n = snprintf(packet, sizeof packet, "T%02xthread:1;", (unsigned)signal);
    if (status == MR_OK && d->hold_reason == HIL_HOLD_WATCHPOINT)
        snprintf(packet + n, sizeof packet - (size_t)n, "%swatch:%x;",
                 d->hit_kind == HIL_WATCH_READ     ? "r"
                 : d->hit_kind == HIL_WATCH_ACCESS ? "a"
                                                   : "",
                 (unsigned)d->hit_address);
    gdb->is_hold_reported = true;
    send_packet(&gdb->connection, packet);
}

/* vCont;ACTION[;ACTION...]: there is only one thread, so the first action applies. Returns true if
 * the board continues. */
static bool resume_as_requested(struct hil_gdb *gdb, const char *action)
{
    if (*action == 'c' || *action == 'C')
        hil_debug_run(gdb->board);
    else if (*action == 's' || *action == 'S')
        hil_debug_step(gdb->board);
    else
        return false;
    return true;
}

/* Handles a packet while the board is held. Returns true if the board continues. */
static bool handle_packet(struct hil_gdb *gdb, const char *packet, enum mr_status status)
{
    char answer[2 * HIL_GDB_PACKET_MAX] = "";
    unsigned number;
    const char *equals = strchr(packet, '=');
    switch (packet[0]) {
    case '?': report_stop(gdb, status); return false;
    case 'g':
        for (unsigned i = 0; i < HIL_REG_COUNT; i++)
            format_register(gdb, i, answer + strlen(answer));
        break;
    case 'p':
        number = (unsigned)strtoul(packet + 1, NULL, 16);
        if (number < HIL_REG_COUNT)
            format_register(gdb, number, answer);
        else
            strcpy(answer, "E01");
        break;
    case 'P':
        number = (unsigned)strtoul(packet + 1, NULL, 16);
        strcpy(answer, equals && set_register(gdb, number, equals + 1) ? "OK" : "E01");
        break;
    case 'm': read_memory(gdb, packet + 1, answer); break;
    case 'M': write_memory(gdb, packet + 1, answer); break;
    case 'Z':
    case 'z': set_break_or_watchpoint(gdb, packet + 1, packet[0] == 'Z', answer); break;
    case 'H':
    case 'T': strcpy(answer, "OK"); break;
    case 'D':
        send_packet(&gdb->connection, "OK");
        drop_connection(&gdb->connection);
        return true;
    case 'k':
        gdb->is_kill_requested = true;
        drop_connection(&gdb->connection);
        return true;
    case 'q': answer_query(gdb, packet, answer); break;
    case 'Q':
        if (strcmp(packet, "QStartNoAckMode") == 0) {
            send_packet(&gdb->connection, "OK");
            gdb->connection.is_acknowledging = false;
            return false;
        }
        break;
    case 'v':
        if (strcmp(packet, "vCont?") == 0) {
            strcpy(answer, "vCont;c;C;s;S");
        } else if (strncmp(packet, "vCont;", 6) == 0) {
            if (resume_as_requested(gdb, packet + 6))
                return true;
            strcpy(answer, "E01");
        }
        break;
    default: break; /* not supported: send the empty answer */
    }
    send_packet(&gdb->connection, answer);
    return false;
}

/* Handles packets until gdb lets the board continue. */
static void serve_client(struct hil_gdb *gdb, enum mr_status status, const volatile int *stop)
{
    char packet[2 * HIL_GDB_PACKET_MAX + 1];
    double seen_s = hil_wall_clock_s();
    while (gdb->connection.fd >= 0 && !*stop) {
        bool interrupt;
        double since_s = hil_wall_clock_s() - seen_s;
        if (gdb->is_time_running && status == MR_OK)
            hil_debug_advance(gdb->board,
                              hil_board_now_ps(gdb->board) + (uint64_t)(since_s * 1e12));
        seen_s += since_s;
        int n = extract_next_packet(&gdb->connection, packet, &interrupt);
        if (n < 0) {
            if (!interrupt && !receive_input(&gdb->connection, POLL_INTERVAL_MS))
                return;
            continue;
        }
        if (handle_packet(gdb, packet, status)) {
            gdb->is_hold_reported = false;
            return;
        }
    }
}

static void detach_debugger(void *context)
{
    struct hil_gdb *gdb = context;
    if (gdb->is_attached)
        hil_debug_detach(gdb->board);
    gdb->is_attached = false;
}

static void attach_debugger(struct hil_gdb *gdb)
{
    int one = 1;
    gdb->connection.fd = accept4(gdb->listener, NULL, NULL, SOCK_CLOEXEC);
    if (gdb->connection.fd < 0)
        return;
    if (!gdb->path[0])
        setsockopt(gdb->connection.fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    gdb->connection.is_acknowledging = true;
    gdb->connection.on_disconnect = (struct hil_callback){detach_debugger, gdb};
    gdb->is_attached = true;
    gdb->is_hold_reported = true; /* gdb asks for the stop reason itself */
    gdb->connection.input_size = 0;
    hil_debug_attach(gdb->board, &gdb->debug);
}

/* Prints why the board is held or has stopped, in addition to the stop reply. */
static void send_failure_reason(struct hil_gdb *gdb, enum mr_status status)
{
    char text[512];
    const struct hil_debug *d = &gdb->debug;
    if (status != MR_OK)
        snprintf(text, sizeof text, "the board has stopped: %s\n",
                 hil_board_failure_reason(gdb->board));
    else if (d->hold_reason == HIL_HOLD_WATCHPOINT)
        snprintf(text, sizeof text, "access to 0x%08x by the instruction at 0x%08x\n",
                 (unsigned)d->hit_address, (unsigned)d->hit_pc);
    else if (d->hold_reason == HIL_HOLD_BKPT)
        snprintf(
            text, sizeof text,
            "the firmware executed a BKPT instruction; to step over the instruction, continue\n");
    else
        return;
    send_console_text(&gdb->connection, text);
}

bool hil_gdb_serve(struct hil_gdb *gdb, enum mr_status status, const volatile int *stop)
{
    struct pollfd wait = {.fd = gdb->listener, .events = POLLIN};
    if (gdb->listener < 0)
        return true;
    if (gdb->connection.fd < 0) {
        if (status != MR_OK || poll(&wait, 1, 0) <= 0)
            return true;
        attach_debugger(gdb);
    }
    if (gdb->connection.fd >= 0 && !hil_debug_is_holding(gdb->board) &&
        receive_input(&gdb->connection, 0)) {
        char packet[2 * HIL_GDB_PACKET_MAX + 1];
        bool interrupt;
        /* while the board runs only Ctrl-C can arrive */
        extract_next_packet(&gdb->connection, packet, &interrupt);
        if (interrupt)
            hil_debug_hold(gdb->board, HIL_HOLD_REQUESTED);
    }
    if (gdb->connection.fd < 0 || (!hil_debug_is_holding(gdb->board) && status == MR_OK))
        return true;
    if (!gdb->is_hold_reported) {
        send_failure_reason(gdb, status);
        report_stop(gdb, status);
    }
    serve_client(gdb, status, stop);
    return !gdb->is_kill_requested;
}

/* --- opening and closing --- */

static enum mr_status listen_on_port(struct hil_gdb *gdb, unsigned long port, char *error,
                                     size_t size)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    socklen_t length = sizeof address;
    int one = 1;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    gdb->listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (gdb->listener >= 0)
        setsockopt(gdb->listener, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    if (gdb->listener < 0 ||
        bind(gdb->listener, (const struct sockaddr *)&address, sizeof address) != 0 ||
        listen(gdb->listener, 1) != 0 ||
        getsockname(gdb->listener, (struct sockaddr *)&address, &length) != 0) {
        snprintf(error, size,
                 "--gdb: cannot listen on port %lu: %s; give a different port, or 0 for any", port,
                 strerror(errno));
        return MR_IO;
    }
    snprintf(gdb->address, sizeof gdb->address, "127.0.0.1:%u", ntohs(address.sin_port));
    return MR_OK;
}

enum mr_status hil_gdb_open(struct hil_gdb *gdb, const char *text, char *error, size_t size)
{
    *gdb = (struct hil_gdb){.listener = -1, .connection = {.fd = -1}};
    if (strncmp(text, "unix:", 5) == 0 && text[5]) {
        enum mr_status status = hil_socket_listen("--gdb", text + 5, &gdb->listener, error, size);
        if (status == MR_OK)
            snprintf(gdb->path, sizeof gdb->path, "%s", text + 5);
        snprintf(gdb->address, sizeof gdb->address, "%s", text + 5);
        return status;
    }
    char *end;
    unsigned long port = strtoul(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end || port > 65535) {
        snprintf(error, size, "--gdb cannot be `%s`; give a port (0: any) or unix:PATH", text);
        return MR_USAGE;
    }
    return listen_on_port(gdb, port, error, size);
}

enum mr_status hil_gdb_accept(struct hil_gdb *gdb, struct hil_board *board, int timeout_ms,
                              const volatile int *stop, char *error, size_t size)
{
    int64_t until = hil_wall_clock_ms() + timeout_ms;
    gdb->board = board;
    if (gdb->listener < 0)
        return MR_OK;
    while (gdb->connection.fd < 0 && !*stop && hil_wall_clock_ms() < until) {
        struct pollfd wait = {.fd = gdb->listener, .events = POLLIN};
        if (poll(&wait, 1, POLL_INTERVAL_MS) > 0)
            attach_debugger(gdb);
    }
    if (gdb->connection.fd >= 0)
        return MR_OK;
    snprintf(error, size,
             "--gdb: no debugger connected to %s within %d s; start gdb-multiarch and enter "
             "`target remote %s`",
             gdb->address, timeout_ms / 1000, gdb->address);
    return *stop ? MR_CLOSED : MR_TIMEOUT;
}

void hil_gdb_close(struct hil_gdb *gdb, int exit_code)
{
    char packet[8];
    if (gdb->connection.fd >= 0) {
        snprintf(packet, sizeof packet, "W%02x", (unsigned)exit_code & 0xffu);
        send_packet(&gdb->connection, packet);
        /* wait until gdb acknowledges the packet: closing with unread input would look like an
         * error to gdb */
        receive_input(&gdb->connection, POLL_INTERVAL_MS);
    }
    drop_connection(&gdb->connection);
    if (gdb->listener >= 0)
        close(gdb->listener);
    if (gdb->path[0])
        unlink(gdb->path);
    gdb->listener = -1;
    gdb->path[0] = '\0';
}
