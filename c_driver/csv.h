/* Tables from comma-separated files: columns found by name, every complaint with file, line and column.
 *
 * Lines that are blank or start with '#' are skipped, the first other line is the header. Columns that nobody asks for
 * may hold anything; csv_note_unused tells of them. */
#ifndef CSV_H
#define CSV_H

#include <stddef.h>

typedef struct {
    const char *file; /* as given, for messages */
    char *text;       /* the whole file; names and fields point into it */
    size_t columns;
    size_t rows;
    char **names;  /* [columns] */
    char *used;    /* [columns] 1 once the column was asked for */
    char **fields; /* [rows * columns], row after row */
    long header_line;
    long *lines; /* [rows] line of the file each row stands on, from 1 */
} csv_table;

/* Reads a file; ends the program when there is no such file, no header, no row, or a row of the wrong length. */
csv_table csv_read(const char *file);

/* 1 if the table has a column of this name. */
int csv_has(const csv_table *table, const char *name);

/* The numbers of a column, [rows], to be freed by the caller; ends the program if the column is missing or if a field is
 * not a finite number. */
double *csv_column(const csv_table *table, const char *name);

/* A field as it stands in the file, of a column that is there. */
const char *csv_field(const csv_table *table, const char *name, size_t row);

/* Like csv_column for `time`, which must not decrease. */
double *csv_time(const csv_table *table);

/* A note on standard error about columns that were not asked for: one of them may be an optional column mistyped. Files
 * with more columns than a replay needs are common (records of a rig, the output of another replay), so it is no error. */
void csv_note_unused(const csv_table *table);

void csv_free(csv_table *table);

/* Reads a decimal number in C or Fortran notation (1.5e-3, 1.5D-3) that fills the whole text.
 * Returns NULL, or what is wrong with it ("is not a number", ...). */
const char *read_number(const char *text, double *value);

/* malloc and realloc that end the program when there is no memory left. */
void *allocate(size_t count, size_t size);
void *resize(void *memory, size_t count, size_t size);

#endif
