/* mepc_replay: replays a load history through the contact-law library. See --help, or the text in options.c. */
#include "replay.h"

#include "csv.h"
#include "report.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

replay replay_begin(const options *given, int32_t ndir) {
    replay run = {.given = given, .ndir = ndir};
    run.lib = library_open(given->library);
    run.nstate = given->nstate;
    if (run.nstate == 0) {
        run.nstate = run.lib.state_size(given->props, given->nprops, ndir);
        if (run.nstate < 0) {
            fail("--props: %s", run.lib.last_error());
        }
    }
    int32_t status = run.lib.law_new(given->props, given->nprops, ndir, run.nstate, &run.law);
    if (status < 0) {
        fail("%s: %s", status == MEPC_BAD_STATE ? "--nstate" : "--props", run.lib.last_error());
    }
    return run;
}

void replay_put(replay *run, double value) {
    if (run->count == run->room) {
        run->room = run->room == 0 ? 1024 : 2 * run->room;
        run->values = resize(run->values, run->room, sizeof *run->values);
    }
    run->values[run->count++] = value;
}

/* Seventeen significant digits: a reader gets the numbers back exactly. */
static void write_table(const replay *run, FILE *output, const char *header) {
    size_t columns = 1;
    for (const char *c = header; *c != '\0'; c++) {
        columns += *c == ',';
    }
    fprintf(output, "%s\n", header);
    for (size_t i = 0; i < run->count; i++) {
        fprintf(output, "%.17g%c", run->values[i], (i + 1) % columns == 0 ? '\n' : ',');
    }
}

static void write_output(const replay *run, const char *header) {
    const char *file = run->given->output;
    FILE *output = file == NULL ? stdout : fopen(file, "w");
    if (output == NULL) {
        fail("%s: cannot be written: %s", file, strerror(errno));
    }
    write_table(run, output, header);
    int failed = ferror(output) != 0;
    failed |= fclose(output) != 0;
    if (failed) {
        const char *reason = strerror(errno);
        if (file != NULL && (output = fopen(file, "w")) != NULL) {
            fclose(output); /* emptied, so that nobody takes the part for the whole; it may be a device, so not removed */
        }
        fail("%s: cannot be written: %s", file == NULL ? "standard output" : file, reason);
    }
}

void replay_end(replay *run, const char *header) {
    write_output(run, header);
    if (run->memory_full > 0) {
        note("the memory was full in %ld updates and the least important reversal was dropped, a longer state array "
             "(--nstate, now %d) keeps it",
             run->memory_full, (int)run->nstate);
    }
    free(run->values);
    run->lib.law_free(run->law);
    library_close(&run->lib);
}

int main(int argc, char **argv) {
    options given = options_read(argc, argv);
    if (given.patch == NULL) {
        replay_point(&given);
    } else {
        replay_patch(&given);
    }
    return 0;
}
