/* Messages of the program: every error ends it, with exit code 1 for bad input and 2 for a wrong command line. */
#ifndef REPORT_H
#define REPORT_H

/* The name before every message. */
#define PROGRAM "mepc_replay"

#if defined(__GNUC__)
#define PRINTF_LIKE __attribute__((format(printf, 1, 2)))
#define ENDS_PROGRAM __attribute__((noreturn))
#else
#define PRINTF_LIKE
#define ENDS_PROGRAM
#endif

/* Prints "mepc_replay: <text>" on standard error and exits with code 1. */
ENDS_PROGRAM PRINTF_LIKE void fail(const char *format, ...);

/* Like fail, for the command line: points at --help and exits with code 2. */
ENDS_PROGRAM PRINTF_LIKE void fail_usage(const char *format, ...);

/* Prints "mepc_replay: note: <text>" on standard error and goes on. */
PRINTF_LIKE void note(const char *format, ...);

#endif
