#include "csv.h"

#include "report.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *resize(void *memory, size_t count, size_t size) {
    if (count > SIZE_MAX / size) {
        fail("out of memory");
    }
    size_t bytes = count * size;
    memory = realloc(memory, bytes > 0 ? bytes : 1);
    if (memory == NULL) {
        fail("out of memory");
    }
    return memory;
}

void *allocate(size_t count, size_t size) {
    void *memory = resize(NULL, count, size);
    memset(memory, 0, count * size);
    return memory;
}

static const char *skip_digits(const char *text) {
    while (isdigit((unsigned char)*text)) {
        text++;
    }
    return text;
}

/* 1 for [sign] digits [. digits] [exponent]. strtod alone would also take hexadecimal, "inf" and "nan". */
static int is_decimal(const char *text) {
    text += *text == '+' || *text == '-';
    const char *whole = text;
    text = skip_digits(text);
    long digits = (long)(text - whole);
    if (*text == '.') {
        const char *fraction = ++text;
        text = skip_digits(text);
        digits += (long)(text - fraction);
    }
    if (digits == 0) {
        return 0;
    }
    if (*text != '\0' && strchr("eEdD", *text) != NULL) {
        text++;
        text += *text == '+' || *text == '-';
        const char *exponent = text;
        text = skip_digits(text);
        if (text == exponent) {
            return 0;
        }
    }
    return *text == '\0';
}

/* 1 for what other programs write in place of a number: nan, inf, infinity, in any case and sign. */
static int is_special(const char *text) {
    char lower[16] = "";
    text += *text == '+' || *text == '-';
    if (strlen(text) >= sizeof lower) {
        return 0;
    }
    for (size_t i = 0; text[i] != '\0'; i++) {
        lower[i] = (char)tolower((unsigned char)text[i]);
    }
    return strcmp(lower, "nan") == 0 || strcmp(lower, "inf") == 0 || strcmp(lower, "infinity") == 0;
}

const char *read_number(const char *text, double *value) {
    if (*text == '\0') {
        return "is empty";
    }
    if (is_special(text)) {
        return "is not finite";
    }
    if (!is_decimal(text)) {
        return "is not a number";
    }
    size_t length = strlen(text);
    char *copy = allocate(length + 1, 1);
    for (size_t i = 0; i < length; i++) {
        copy[i] = text[i];
        if (text[i] == 'd' || text[i] == 'D') {
            copy[i] = 'e';
        }
    }
    *value = strtod(copy, NULL);
    free(copy);
    return isfinite(*value) ? NULL : "is too large";
}

static char *read_file(const char *file) {
    FILE *stream = fopen(file, "rb");
    if (stream == NULL) {
        fail("%s: %s", file, strerror(errno));
    }
    char *text = NULL;
    size_t length = 0;
    size_t got = 0;
    do {
        length += got;
        text = resize(text, length + 65536 + 1, 1);
        got = fread(text + length, 1, 65536, stream);
    } while (got > 0);
    if (ferror(stream)) {
        fail("%s: %s", file, strerror(errno));
    }
    fclose(stream);
    text[length] = '\0';
    if (memchr(text, '\0', length) != NULL) {
        fail("%s: is not a text file", file);
    }
    return text;
}

/* Cuts the spaces off both ends, in place. */
static char *trim(char *text) {
    while (isspace((unsigned char)*text)) {
        text++;
    }
    size_t length = strlen(text);
    while (length > 0 && isspace((unsigned char)text[length - 1])) {
        length--;
    }
    text[length] = '\0';
    return text;
}

/* Splits a line at its commas, in place; returns the number of fields, of which the first `room` are stored. */
static size_t split(char *line, char **fields, size_t room) {
    size_t count = 0;
    while (line != NULL) {
        char *comma = strchr(line, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        if (count < room) {
            fields[count] = trim(line);
        }
        count++;
        line = comma == NULL ? NULL : comma + 1;
    }
    return count;
}

static void read_header(csv_table *table, char *line, long number) {
    const char *other = strpbrk(line, ";\t");
    if (other != NULL && strchr(line, ',') == NULL) {
        fail("%s:%ld: the fields must be separated by commas, not by %s", table->file, number,
             *other == ';' ? "semicolons" : "tabs");
    }
    size_t most = strlen(line) + 1;
    table->header_line = number;
    table->names = allocate(most, sizeof *table->names);
    table->columns = split(line, table->names, most);
    table->used = allocate(table->columns, 1);
    for (size_t i = 0; i < table->columns; i++) {
        for (size_t k = 0; k < i; k++) {
            if (table->names[i][0] != '\0' && strcmp(table->names[i], table->names[k]) == 0) {
                fail("%s:%ld: column %s: appears twice in the header", table->file, number, table->names[i]);
            }
        }
    }
}

static void add_row(csv_table *table, char *line, long number) {
    size_t columns = table->columns;
    if ((table->rows & (table->rows - 1)) == 0) { /* no room left at each power of two: double it */
        size_t room = table->rows == 0 ? 1 : 2 * table->rows;
        table->fields = resize(table->fields, room * columns, sizeof *table->fields);
        table->lines = resize(table->lines, room, sizeof *table->lines);
    }
    size_t found = split(line, table->fields + table->rows * columns, columns);
    if (found < columns) {
        fail("%s:%ld: column %s: missing, the line has %lu fields and the header %lu", table->file, number,
             table->names[found], (unsigned long)found, (unsigned long)columns);
    }
    if (found > columns) {
        fail("%s:%ld: column %lu: has no name, the line has %lu fields and the header %lu", table->file, number,
             (unsigned long)columns + 1, (unsigned long)found, (unsigned long)columns);
    }
    table->lines[table->rows] = number;
    table->rows++;
}

csv_table csv_read(const char *file) {
    csv_table table = {.file = file, .text = read_file(file)};
    long number = 0;
    char *line = table.text;
    if (strncmp(line, "\xef\xbb\xbf", 3) == 0) { /* byte order mark of some spreadsheets */
        line += 3;
    }
    while (line != NULL && *line != '\0') {
        char *end = strchr(line, '\n');
        if (end != NULL) {
            *end = '\0';
        }
        number++;
        char *content = trim(line);
        if (*content != '\0' && *content != '#') {
            if (table.columns == 0) {
                read_header(&table, content, number);
            } else {
                add_row(&table, content, number);
            }
        }
        line = end == NULL ? NULL : end + 1;
    }
    if (table.columns == 0) {
        fail("%s:%ld: is empty: no header line", file, number > 0 ? number : 1);
    }
    if (table.rows == 0) {
        fail("%s:%ld: has a header but no row below it", file, table.header_line);
    }
    return table;
}

static int find(const csv_table *table, const char *name, size_t *column) {
    for (*column = 0; *column < table->columns; (*column)++) {
        if (strcmp(table->names[*column], name) == 0) {
            return 1;
        }
    }
    return 0;
}

int csv_has(const csv_table *table, const char *name) {
    size_t column;
    return find(table, name, &column);
}

const char *csv_field(const csv_table *table, const char *name, size_t row) {
    size_t column;
    find(table, name, &column);
    return table->fields[row * table->columns + column];
}

/* The names of all columns, or of those that were not asked for; to be freed by the caller. */
static char *list_names(const csv_table *table, int all) {
    size_t room = 1;
    for (size_t i = 0; i < table->columns; i++) {
        room += strlen(table->names[i]) + 64;
    }
    char *list = allocate(room, 1);
    for (size_t i = 0; i < table->columns; i++) {
        if (table->used[i] && !all) {
            continue;
        }
        strcat(list, list[0] == '\0' ? "" : ", ");
        if (table->names[i][0] == '\0') {
            sprintf(list + strlen(list), "%lu (no name)", (unsigned long)i + 1);
        } else {
            strcat(list, table->names[i]);
        }
    }
    return list;
}

double *csv_column(const csv_table *table, const char *name) {
    size_t column;
    if (!find(table, name, &column)) {
        fail("%s:%ld: column %s: missing in the header, which has %s", table->file, table->header_line, name,
             list_names(table, 1));
    }
    table->used[column] = 1;
    double *values = allocate(table->rows, sizeof *values);
    for (size_t row = 0; row < table->rows; row++) {
        const char *field = csv_field(table, name, row);
        const char *problem = read_number(field, &values[row]);
        if (problem != NULL) {
            free(values);
            fail("%s:%ld: column %s: '%s' %s", table->file, table->lines[row], name, field, problem);
        }
    }
    return values;
}

double *csv_time(const csv_table *table) {
    double *time = csv_column(table, "time");
    for (size_t row = 1; row < table->rows; row++) {
        if (time[row] < time[row - 1]) {
            free(time);
            fail("%s:%ld: column time: %s comes after %s, time must not decrease", table->file, table->lines[row],
                 csv_field(table, "time", row), csv_field(table, "time", row - 1));
        }
    }
    return time;
}

void csv_note_unused(const csv_table *table) {
    char *list = list_names(table, 0);
    if (list[0] != '\0') {
        note("%s:%ld: columns not used: %s", table->file, table->header_line, list);
    }
    free(list);
}

void csv_free(csv_table *table) {
    free(table->text);
    free(table->names);
    free(table->used);
    free(table->fields);
    free(table->lines);
    *table = (csv_table){0};
}
