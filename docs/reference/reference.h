/* The pages of docs/reference, made from the tables that the programs are made from. `make
 * reference` writes them; a test says when the committed page is another one. Each writes one page
 * of Markdown. */
#ifndef MATRIG_DOCS_REFERENCE_REFERENCE_H
#define MATRIG_DOCS_REFERENCE_REFERENCE_H

#include <stdio.h>

/* Title, and from which table the page is made. */
void reference_head(FILE *out, const char *title, const char *source);
/* Text for a cell of a table: no bar ends the cell. */
void reference_cell(FILE *out, const char *text);

void reference_commands(FILE *out); /* host/commands/commands.def and its descriptors */
/* common/catalogue.def, common/command.h, common/fault.h */
void reference_messages(FILE *out);
void reference_configuration(FILE *out); /* common/config.def */
void reference_pins(FILE *out);          /* firmware/boards/pins.def */
void reference_scene(FILE *out);         /* host/sim/scene/scene.c */
void reference_bringup(FILE *out);       /* host/board/bringup_limits.def */
void reference_units(FILE *out);         /* host/base/quantity.c */
void reference_exit_codes(FILE *out);    /* common/status.h */
/* host/store/tables.def, whose comments it reads from the file. Exits with a line on stderr when
 * the file is not there. */
void reference_campaign(FILE *out);

#endif
