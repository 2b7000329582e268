/* The command line. */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stdint.h>

#define MAX_PROPS 64

typedef struct {
    const char *patch;   /* patch file, or NULL for a single point */
    const char *history; /* history file */
    const char *output;  /* output file, or NULL for standard output */
    const char *library; /* path of the shared library */
    double props[MAX_PROPS];
    int32_t nprops;
    int32_t nstate;  /* 0: the library's default */
    double series;   /* stiffness of the series spring, force per length; 0: rigid */
    double parallel; /* stiffness of the parallel spring, force per length; 0: none */
} options;

/* Reads the command line; ends the program with exit code 2 when it is wrong, with 1 when the output is one of the input
 * files, with 0 after --help. */
options options_read(int argc, char **argv);

#endif
