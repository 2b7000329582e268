/* mepc_replay: replays a load history through the contact-law library. See --help, or the text in options.c. */
#include "replay.h"

#include "report.h"

#include <errno.h>
#include <string.h>

replay replay_begin(const options *given, int32_t ndir) {
    replay run = {.given = given, .ndir = ndir, .output = stdout};
    run.lib = library_open(given->library);
    run.nstate = given->nstate;
    if (run.nstate == 0) {
        run.nstate = run.lib.state_size(given->props, given->nprops, ndir);
        if (run.nstate < 0) {
            fail("--props: %s", run.lib.last_error());
        }
    }
    if (run.lib.law_new(given->props, given->nprops, ndir, run.nstate, &run.law) < 0) {
        fail("--props, --nstate: %s", run.lib.last_error());
    }
    return run;
}

void replay_open_output(replay *run) {
    const char *file = run->given->output;
    if (file != NULL) {
        run->output = fopen(file, "w");
        if (run->output == NULL) {
            fail("%s: %s", file, strerror(errno));
        }
    }
}

void replay_end(replay *run) {
    const char *file = run->given->output == NULL ? "standard output" : run->given->output;
    int failed = ferror(run->output) != 0;
    failed |= fclose(run->output) != 0;
    if (failed) {
        fail("%s: cannot be written: %s", file, strerror(errno));
    }
    if (run->memory_full > 0) {
        fprintf(stderr,
                PROGRAM ": note: the memory was full in %ld updates and the least important reversal was dropped, "
                        "a longer state array (--nstate, now %d) keeps it\n",
                run->memory_full, (int)run->nstate);
    }
    run->lib.law_free(run->law);
    library_close(&run->lib);
}

void write_number(FILE *output, double value) {
    fprintf(output, ",%.17g", value);
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
