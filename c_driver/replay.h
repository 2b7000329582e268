/* The two modes of the program. */
#ifndef REPLAY_H
#define REPLAY_H

#include "library.h"
#include "options.h"

#include <stddef.h>

/* What both modes work with. */
typedef struct {
    const options *given;
    library lib;
    mepc_law *law;
    int32_t ndir;   /* tangential directions, 1 or 2 */
    int32_t nstate; /* doubles per point */
    double *values; /* the numbers of the output, row after row */
    size_t count;
    size_t room;
    long memory_full; /* updates that had to drop a remembered reversal */
} replay;

/* State slot 1 (index 0) of every point: what its contact does. */
enum { OPEN, STICK, MICRO_SLIP, GROSS_SLIP, CONTACT_KINDS };

/* Loads the library and makes the law for `ndir` directions. */
replay replay_begin(const options *given, int32_t ndir);

/* Adds a number to the output, which is kept until replay_end: a run that fails leaves no half table behind. */
void replay_put(replay *run, double value);

/* Writes the output, a line of column names and the numbers below them, and closes the library. */
void replay_end(replay *run, const char *header);

/* One point under prescribed slip and pressure. */
void replay_point(const options *given);

/* Points that share a rigid tangential motion, with springs in series and in parallel. */
void replay_patch(const options *given);

#endif
