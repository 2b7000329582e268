/* Tables of numbers from comma-separated files; an error names file, line and column. */
#include "mepc_replay.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("mepc_replay: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    exit(1);
}

void *allocate(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fail("out of memory");
    }
    return memory;
}

int read_number(const char *text, double *value) {
    char *end;
    *value = strtod(text, &end);
    /* strtod alone would also take hexadecimal numbers, "inf" and "nan". */
    return end != text && *end == '\0' && strspn(text, "0123456789+-.eE") == strlen(text) && isfinite(*value);
}

void table_add(table *t, const table *input, size_t row, const double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (!isfinite(values[i])) { /* a sum or product of this program: what the library gives is finite */
            fail("%s:%ld: the result is not a finite number", input->file, input->lines[row]);
        }
        if (t->count == t->room) {
            t->room = t->room > 0 ? 2 * t->room : 1024;
            t->values = realloc(t->values, t->room * sizeof *t->values);
            t->lines = realloc(t->lines, t->room * sizeof *t->lines);
            if (t->values == NULL || t->lines == NULL) {
                fail("out of memory");
            }
        }
        t->values[t->count++] = values[i];
    }
}

static void read_header(table *t, const char *line, long number, const char *const *headers) {
    char accepted[512] = "";
    for (; *headers != NULL; headers++) {
        if (strcmp(line, *headers) == 0) {
            t->header = *headers;
            for (t->columns = 1; *line != '\0'; line++) {
                t->columns += *line == ',';
            }
            return;
        }
        strcat(strcat(accepted, accepted[0] == '\0' ? "" : " or "), *headers);
    }
    fail("%s:%ld: the header is '%s', must be %s", t->file, number, line, accepted);
}

static void read_row(table *t, char *line, long number) {
    const char *header = t->header;
    for (size_t i = 0; i < t->columns; i++) {
        int name = (int)strcspn(header, ",");
        char *comma = strchr(line, ',');
        if ((comma == NULL) != (i + 1 == t->columns)) {
            fail("%s:%ld: column %.*s: too %s fields in this row", t->file, number, name, header,
                 comma == NULL ? "few" : "many");
        }
        if (comma != NULL) {
            *comma = '\0';
        }
        double value;
        if (!read_number(line, &value)) {
            fail("%s:%ld: column %.*s: '%s' is not a finite number", t->file, number, name, header, line);
        }
        table_add(t, t, 0, &value, 1);
        line = comma + 1;
        header += name + 1;
    }
    t->lines[t->count / t->columns - 1] = number;
}

table table_read(const char *file, const char *const *headers) {
    table t = {.file = file};
    char line[4096];
    long number = 0;
    FILE *stream = fopen(file, "r");
    while (stream != NULL && fgets(line, sizeof line, stream) != NULL) {
        number++;
        if (strlen(line) + 1 == sizeof line) {
            fail("%s:%ld: the line is too long", file, number);
        }
        line[strcspn(line, "\r\n")] = '\0';
        if (line[0] != '\0' && line[0] != '#') {
            if (t.header == NULL) {
                read_header(&t, line, number, headers);
            } else {
                read_row(&t, line, number);
            }
        }
    }
    if (stream == NULL || ferror(stream)) {
        fail("%s: %s", file, strerror(errno));
    }
    fclose(stream);
    if (t.count == 0) {
        fail("%s:%ld: the file ends without a row of numbers", file, number);
    }
    return t;
}
