#include "library.h"

#include "csv.h"
#include "report.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>


/* Stores the address of a symbol in a function pointer. POSIX gives both the same representation; ISO C has no cast from
 * the void pointer that dlsym returns, hence memcpy. */
static void load(const library *lib, const char *symbol, void *function) {
    void *address = dlsym(lib->handle, symbol);
    if (address == NULL) {
        fail("%s: has no function %s: not the contact-law library, or an older one", lib->path, symbol);
    }
    memcpy(function, &address, sizeof address);
}

/* Assigning the header's functions lets the compiler compare the prototypes; inside sizeof nothing is executed or linked. */
#define LOAD(name)                                          \
    do {                                                    \
        (void)sizeof(lib.name = mepc_##name);               \
        load(&lib, "mepc_" #name, (void *)(&lib.name));     \
    } while (0)

/* dlopen looks for a name without a slash in the system's places; here it is a file like any other. */
static void *open_file(const char *path) {
    if (strchr(path, '/') != NULL) {
        return dlopen(path, RTLD_NOW | RTLD_LOCAL);
    }
    char *here = allocate(strlen(path) + 3, 1);
    strcpy(here, "./");
    strcat(here, path);
    void *handle = dlopen(here, RTLD_NOW | RTLD_LOCAL);
    free(here);
    return handle;
}

library library_open(const char *path) {
    library lib = {.path = path};
    lib.handle = open_file(path);
    if (lib.handle == NULL) {
        fail("cannot load the library: %s", dlerror());
    }
    LOAD(abi_version);
    LOAD(last_error);
    LOAD(state_size);
    LOAD(law_new);
    LOAD(law_free);
    LOAD(friction);
    LOAD(friction_batch);
    int32_t version = lib.abi_version();
    if (version != MEPC_ABI_VERSION) {
        fail("%s: has ABI version %d, this program is written for %d", path, (int)version, MEPC_ABI_VERSION);
    }
    return lib;
}

void library_close(library *lib) {
    dlclose(lib->handle);
    *lib = (library){0};
}
