/* Stands for libserialport, for tests by LD_PRELOAD: the serial ports are the files in the folder
 * $PORTS, "TTY VENDOR PRODUCT SERIAL" each: a terminal, and the USB adapter it shall be; "-": no
 * serial number. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libserialport.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct sp_port {
    char name[400], tty[64], serial[64];
    int vendor, product, fd;
};

enum sp_return sp_get_port_by_name(const char *name, struct sp_port **made)
{
    struct sp_port *port = calloc(1, sizeof *port);
    FILE *file = fopen(name, "r");
    int read = file ? fscanf(file, "%63s %x %x %63s", port->tty, (unsigned *)&port->vendor,
                             (unsigned *)&port->product, port->serial)
                    : 0;
    if (file)
        fclose(file);
    snprintf(port->name, sizeof port->name, "%s", name);
    *made = port;
    return read == 4 ? SP_OK : SP_ERR_ARG;
}

void sp_free_port(struct sp_port *port)
{
    free(port);
}

enum sp_return sp_list_ports(struct sp_port ***list)
{
    char path[400];
    size_t count = 0;
    DIR *folder = opendir(getenv("PORTS"));
    *list = calloc(10, sizeof **list);
    for (struct dirent *file; folder && (file = readdir(folder)) && count < 9;) {
        snprintf(path, sizeof path, "%s/%.99s", getenv("PORTS"), file->d_name);
        count += file->d_name[0] != '.' && sp_get_port_by_name(path, &(*list)[count]) == SP_OK;
    }
    (*list)[count] = NULL;
    closedir(folder);
    return SP_OK;
}

void sp_free_port_list(struct sp_port **list)
{
    for (size_t i = 0; list[i]; i++)
        free(list[i]);
    free(list);
}

char *sp_get_port_name(const struct sp_port *port)
{
    return (char *)port->name;
}

enum sp_transport sp_get_port_transport(const struct sp_port *port)
{
    (void)port;
    return SP_TRANSPORT_USB;
}

enum sp_return sp_get_port_usb_vid_pid(const struct sp_port *port, int *vendor, int *product)
{
    *vendor = port->vendor;
    *product = port->product;
    return SP_OK;
}

char *sp_get_port_usb_serial(const struct sp_port *port)
{
    return port->serial[0] == '-' ? NULL : (char *)port->serial;
}

enum sp_return sp_open(struct sp_port *port, enum sp_mode mode)
{
    (void)mode;
    port->fd = open(port->tty, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    return port->fd < 0 ? SP_ERR_FAIL : SP_OK;
}

enum sp_return sp_close(struct sp_port *port)
{
    return close(port->fd) == 0 ? SP_OK : SP_ERR_FAIL;
}

enum sp_return sp_get_port_handle(const struct sp_port *port, void *handle)
{
    *(int *)handle = port->fd;
    return SP_OK;
}

enum sp_return sp_nonblocking_read(struct sp_port *port, void *bytes, size_t size)
{
    ssize_t count = read(port->fd, bytes, size);
    return count < 0 && errno != EAGAIN ? SP_ERR_FAIL : count < 0 ? 0 : (enum sp_return)count;
}

enum sp_return sp_blocking_write(struct sp_port *port, const void *bytes, size_t size, unsigned ms)
{
    (void)ms;
    return write(port->fd, bytes, size) < 0 ? SP_ERR_FAIL : (enum sp_return)size;
}

int sp_last_error_code(void)
{
    return errno;
}

/* What a terminal takes that is no line. */
#define TAKES(name, type)                             \
    enum sp_return name(struct sp_port *port, type x) \
    {                                                 \
        (void)port;                                   \
        (void)x;                                      \
        return SP_OK;                                 \
    }
TAKES(sp_set_baudrate, int)
TAKES(sp_set_bits, int)
TAKES(sp_set_parity, enum sp_parity)
TAKES(sp_set_stopbits, int)
TAKES(sp_set_flowcontrol, enum sp_flowcontrol)
TAKES(sp_get_config, struct sp_port_config *)
TAKES(sp_flush, enum sp_buffer)
