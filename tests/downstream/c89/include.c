/* SPDX-License-Identifier: MIT OR Apache-2.0 */
/* The header in a program of the oldest standard. */
#include <mepc.h>

int main(void)
{
    return mepc_abi_version() != MEPC_ABI_VERSION;
}
