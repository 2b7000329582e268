#include "report.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* What a file or an argument holds may be part of the text: control characters must not reach the terminal. */
static void say(const char *prefix, const char *format, va_list arguments) {
    char text[8192];
    vsnprintf(text, sizeof text, format, arguments);
    fputs(prefix, stderr);
    for (const char *c = text; *c != '\0'; c++) {
        if (iscntrl((unsigned char)*c)) {
            fprintf(stderr, "\\x%02X", (unsigned)*c);
        } else {
            fputc(*c, stderr);
        }
    }
    fputc('\n', stderr);
}

void fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(PROGRAM ": ", format, arguments);
    va_end(arguments);
    exit(1);
}

void fail_usage(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(PROGRAM ": ", format, arguments);
    va_end(arguments);
    fputs(PROGRAM ": try --help\n", stderr);
    exit(2);
}

void note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(PROGRAM ": note: ", format, arguments);
    va_end(arguments);
}
