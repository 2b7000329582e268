/* The contact-law library, loaded at run time as an FE program loads a user routine. */
#include "mepc_replay.h"

#include <dlfcn.h>
#include <string.h>

/* Stores the address of a symbol in a function pointer. POSIX gives both the same representation; ISO C has no cast
 * from the void pointer that dlsym returns, hence memcpy. */
static void load(void *handle, const char *path, const char *symbol, void *function) {
    void *address = dlsym(handle, symbol);
    if (address == NULL) {
        fail("%s: has no function %s", path, symbol);
    }
    memcpy(function, &address, sizeof address);
}

/* Inside sizeof nothing is executed or linked: the compiler compares the prototype with that of the header. */
#define LOAD(name) \
    ((void)sizeof(lib.name = mepc_##name), load(lib.handle, path, "mepc_" #name, (void *)&lib.name))

library library_open(const char *path) {
    library lib = {.handle = dlopen(path, RTLD_NOW | RTLD_LOCAL)};
    if (lib.handle == NULL) {
        fail("cannot load the library: %s", dlerror());
    }
    LOAD(abi_version);
    if (lib.abi_version() != MEPC_ABI_VERSION) {
        fail("%s: has ABI version %d, this program is written for %d", path, (int)lib.abi_version(), MEPC_ABI_VERSION);
    }
    LOAD(last_error);
    LOAD(state_size);
    LOAD(law_new);
    LOAD(law_free);
    LOAD(friction);
    LOAD(friction_history);
    LOAD(interface);
    LOAD(friction_batch);
    return lib;
}
