/* SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * The friction routines of Abaqus, passed on to libmepc.so. Give this file to Abaqus as user=shim.c.
 *
 * Abaqus runs user code from a scratch copy, so the library is opened by an absolute path: the one below, or that in
 * the environment variable MEPC_LIBRARY. All arguments are addresses and are handed over as they come; the lengths of
 * the character arguments that Fortran appends are not needed. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

/* Write the path here: #define MEPC_LIBRARY "/absolute/path/to/libmepc.so" */
#ifndef MEPC_LIBRARY
#define MEPC_LIBRARY NULL
#endif

/* Ten addresses x0 .. x9: declared, and handed over. */
#define TAKE10(x) void *x##0, void *x##1, void *x##2, void *x##3, void *x##4, TAKE5(x)
#define TAKE5(x) void *x##5, void *x##6, void *x##7, void *x##8, void *x##9
#define GIVE10(x) x##0, x##1, x##2, x##3, x##4, GIVE5(x)
#define GIVE5(x) x##5, x##6, x##7, x##8, x##9

#define TAKE39 TAKE10(a), TAKE10(b), TAKE10(c), TAKE5(d), void *e0, void *e1, void *e2, void *e3
#define GIVE39 GIVE10(a), GIVE10(b), GIVE10(c), GIVE5(d), e0, e1, e2, e3
#define TAKE42 TAKE39, void *f0, void *f1, void *f2
#define GIVE42 GIVE39, f0, f1, f2
#define TAKE47 TAKE42, TAKE5(g)
#define GIVE47 GIVE42, GIVE5(g)

typedef void routine39(TAKE39);
typedef void routine42(TAKE42);
typedef void routine47(TAKE47);

/* By ISO C no cast leads from an address to a function; by POSIX this one does. */
union symbol {
    void *address;
    routine39 *of39;
    routine42 *of42;
    routine47 *of47;
};

static union symbol fric, uinter, vfric, vfriction;
static pthread_once_t opened = PTHREAD_ONCE_INIT;

static void stop(const char *what)
{
    fprintf(stderr, "mepc shim: %s\n", what);
    exit(EXIT_FAILURE);
}

static union symbol find(void *library, const char *name)
{
    union symbol found;
    found.address = dlsym(library, name);
    if (!found.address) {
        stop(dlerror());
    }
    return found;
}

static void open_library(void)
{
    const char *path = getenv("MEPC_LIBRARY");
    void *library;

    if (!path) {
        path = MEPC_LIBRARY;
    }
    if (!path || path[0] != '/') {
        stop("no absolute path to libmepc.so: set MEPC_LIBRARY, in this file or in the environment");
    }
    library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        stop(dlerror());
    }
    fric = find(library, "fric_");
    uinter = find(library, "uinter_");
    vfric = find(library, "vfric_");
    vfriction = find(library, "vfriction_");
}

void fric_(TAKE39);
void uinter_(TAKE47);
void vfric_(TAKE42);
void vfriction_(TAKE39);

void fric_(TAKE39)
{
    pthread_once(&opened, open_library);
    fric.of39(GIVE39);
}

void uinter_(TAKE47)
{
    pthread_once(&opened, open_library);
    uinter.of47(GIVE47);
}

void vfric_(TAKE42)
{
    pthread_once(&opened, open_library);
    vfric.of42(GIVE42);
}

void vfriction_(TAKE39)
{
    pthread_once(&opened, open_library);
    vfriction.of39(GIVE39);
}
