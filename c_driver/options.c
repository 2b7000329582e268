#include "options.h"

#include "csv.h"
#include "report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char help[] =
    "Replays a load history through the memory-effect penalty contact law.\n"
    "\n"
    "  " PROGRAM " point HISTORY.csv --props mu,gcr,... --library PATH [options]\n"
    "  " PROGRAM " patch PATCH.csv HISTORY.csv --props mu,gcr,... --library PATH [options]\n"
    "\n"
    "point  one contact point under prescribed slip and pressure.\n"
    "         HISTORY  time,slip_1[,slip_2],pressure\n"
    "         output   time,slip_1[,slip_2],pressure,traction_1[,traction_2],\n"
    "                  stored_energy,dissipated_energy,status\n"
    "patch  contact points that share one rigid tangential motion.\n"
    "         PATCH    x,y,area,pressure\n"
    "         HISTORY  time,displacement_1[,displacement_2][,rotation][,pressure_scale]\n"
    "         output   time,displacement_1[,displacement_2][,rotation],slip_1[,slip_2],\n"
    "                  force_1[,force_2][,moment],stored_energy,dissipated_energy,\n"
    "                  open,stick,micro_slip,gross_slip,iterations\n"
    "\n"
    "Each row holds the values at the end of a step; the first row is a step too, from zero slip and zero pressure.\n"
    "Pressure is positive in compression; zero or less is an open contact. dissipated_energy counts from the start.\n"
    "status: 0 open, 1 stick, 2 micro-slip, 3 gross slip. rotation (radian, about the origin) needs two directions.\n"
    "Any consistent units. Columns are found by name, those that are not used are noted; lines starting with # are skipped.\n"
    "\n"
    "  --props LIST      properties in their order: mu,gcr,chi,method,pressure_rule,... (required)\n"
    "  --library PATH    the shared library (or environment variable MEPC_LIBRARY)\n"
    "  --nstate N        length of the state array (default: what the library recommends)\n"
    "  --series K        patch: spring in series, K (u - g) = contact force (default: rigid)\n"
    "  --parallel K      patch: spring in parallel, adds K u to the force (default: none)\n"
    "  --output FILE     write the table there (default: standard output)\n"
    "  --help            this text\n"
    "\n"
    "Exit code: 0 done, 1 bad input, 2 wrong command line.\n";

static double read_stiffness(const char *option, const char *text) {
    double value;
    const char *problem = read_number(text, &value);
    if (problem != NULL) {
        fail_usage("%s: '%s' %s", option, text, problem);
    }
    if (!(value > 0.0)) {
        fail_usage("%s: must be positive, not %s", option, text);
    }
    return value;
}

static int32_t read_count(const char *option, const char *text) {
    size_t length = strlen(text);
    long value = 0;
    if (length < 8 && strspn(text, "0123456789") == length) {
        value = strtol(text, NULL, 10);
    }
    if (value < 1 || value > 1000000) {
        fail_usage("%s: '%s' is not a whole number from 1 to 1000000", option, text);
    }
    return (int32_t)value;
}

static void read_props(options *given, const char *list) {
    char *copy = allocate(strlen(list) + 1, 1);
    strcpy(copy, list);
    for (char *entry = copy; entry != NULL;) {
        char *comma = strchr(entry, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        entry += strspn(entry, " ");
        for (char *end = entry + strlen(entry); end > entry && end[-1] == ' ';) {
            *--end = '\0';
        }
        int number = (int)given->nprops + 1;
        if (number > MAX_PROPS) {
            fail_usage("--props: more than %d entries", MAX_PROPS);
        }
        const char *problem = read_number(entry, &given->props[given->nprops]);
        if (problem != NULL) {
            fail_usage("--props: entry %d: '%s' %s", number, entry, problem);
        }
        given->nprops++;
        entry = comma == NULL ? NULL : comma + 1;
    }
    free(copy);
}

static const char *const known[] = {"--props", "--library", "--nstate", "--series", "--parallel", "--output"};
enum { OPTIONS = sizeof known / sizeof known[0] };

static void read_option(options *given, const char *name, const char *value, int seen[OPTIONS]) {
    size_t option = 0;
    while (option < OPTIONS && strcmp(name, known[option]) != 0) {
        option++;
    }
    if (option == OPTIONS) {
        fail_usage("unknown option %s", name);
    }
    if (seen[option]++) {
        fail_usage("%s: given twice", name);
    }
    if (value == NULL || value[0] == '\0' || strncmp(value, "--", 2) == 0) { /* the next option is no value */
        fail_usage("%s: its value is missing", name);
    }
    switch (option) {
    case 0: read_props(given, value); break;
    case 1: given->library = value; break;
    case 2: given->nstate = read_count(name, value); break;
    case 3: given->series = read_stiffness(name, value); break;
    case 4: given->parallel = read_stiffness(name, value); break;
    default: given->output = value; break;
    }
}

/* Ends the program if the output is this file, by whatever name or link. */
static void check_output(const char *output, const char *what, const char *input) {
    struct stat out, in;
    if (stat(output, &out) == 0 && stat(input, &in) == 0 && out.st_dev == in.st_dev && out.st_ino == in.st_ino) {
        fail("--output: %s is the %s %s, which it would overwrite", output, what, input);
    }
}

options options_read(int argc, char **argv) {
    options given = {.library = getenv("MEPC_LIBRARY")};
    int seen[OPTIONS] = {0};
    const char *words[3] = {NULL, NULL, NULL}; /* mode and files */
    int count = 0;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0) {
            fputs(help, stdout);
            exit(0);
        }
        if (strncmp(argv[i], "--", 2) == 0) {
            read_option(&given, argv[i], i + 1 < argc ? argv[i + 1] : NULL, seen);
            i++;
        } else if (count < 3) {
            words[count++] = argv[i];
        } else {
            fail_usage("unexpected argument %s", argv[i]);
        }
    }
    if (count == 0) {
        fail_usage("the mode is missing: point or patch");
    }
    int is_patch = strcmp(words[0], "patch") == 0;
    if (!is_patch && strcmp(words[0], "point") != 0) {
        fail_usage("unknown mode %s: point or patch", words[0]);
    }
    if (count != (is_patch ? 3 : 2)) {
        fail_usage("mode %s takes %s", words[0], is_patch ? "PATCH.csv HISTORY.csv" : "HISTORY.csv");
    }
    if (!is_patch && (given.series > 0.0 || given.parallel > 0.0)) {
        fail_usage("--series and --parallel belong to mode patch");
    }
    if (given.nprops == 0) {
        fail_usage("--props is missing");
    }
    if (given.library == NULL || given.library[0] == '\0') {
        fail_usage("--library (or the environment variable MEPC_LIBRARY) is missing");
    }
    given.patch = is_patch ? words[1] : NULL;
    given.history = words[count - 1];
    if (given.output != NULL) {
        check_output(given.output, "library", given.library);
        for (int i = 1; i < count; i++) {
            check_output(given.output, "input file", words[i]);
        }
    }
    return given;
}
