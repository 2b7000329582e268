/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* A solver with a UMAT of its own links the library without that face. */
#include <mepc.h>
#include <stdio.h>

void umat_(void) { puts("the program's own umat_"); }

int main(void)
{
    umat_();
    return mepc_abi_version() != MEPC_ABI_VERSION;
}
