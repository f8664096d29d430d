/* What matrig error is asked for, as its rows (host/commands/error_command.c) put it there;
 * host/study/error_run.c does it. */
#ifndef MATRIG_HOST_ERROR_COMMAND_H
#define MATRIG_HOST_ERROR_COMMAND_H

struct error_request {
    const char *plot;
};

#endif
