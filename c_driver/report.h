/* Messages of the program: every error ends it, with exit code 1 for bad input and 2 for a wrong command line. */
#ifndef REPORT_H
#define REPORT_H

/* The name before every message. */
#define PROGRAM "mepc_replay"

#if defined(__GNUC__)
#define PRINTF_LIKE(text, first) __attribute__((format(printf, text, first), noreturn))
#else
#define PRINTF_LIKE(text, first)
#endif

/* Prints "mepc_replay: <text>" on standard error and exits with code 1. */
PRINTF_LIKE(1, 2) void fail(const char *format, ...);

/* Like fail, for the command line: points at --help and exits with code 2. */
PRINTF_LIKE(1, 2) void fail_usage(const char *format, ...);

#endif
