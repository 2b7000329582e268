/* The two modes of the program. */
#ifndef REPLAY_H
#define REPLAY_H

#include "library.h"
#include "options.h"

#include <stdio.h>

/* What both modes work with. */
typedef struct {
    const options *given;
    library lib;
    mepc_law *law;
    int32_t ndir;   /* tangential directions, 1 or 2 */
    int32_t nstate; /* doubles per point */
    FILE *output;
    long memory_full; /* updates that had to drop a remembered reversal */
} replay;

/* State slot 1 (index 0) of every point: what its contact does. */
enum { OPEN, STICK, MICRO_SLIP, GROSS_SLIP, CONTACT_KINDS };

/* Loads the library and makes the law for `ndir` directions. */
replay replay_begin(const options *given, int32_t ndir);

/* Opens the output: called when all input has been read, so that bad input leaves no file behind. */
void replay_open_output(replay *run);

/* Closes the output and the library. */
void replay_end(replay *run);

/* Writes ",value" with 17 significant digits, which a reader gets back exactly. */
void write_number(FILE *output, double value);

/* One point under prescribed slip and pressure. */
void replay_point(const options *given);

/* Points that share a rigid tangential motion, with springs in series and in parallel. */
void replay_patch(const options *given);

#endif
