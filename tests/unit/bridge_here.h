// SPDX-License-Identifier: Apache-2.0
/* The bridges of this build, for tests, which it puts one folder below them. */
#ifndef BRIDGE_HERE_H
#define BRIDGE_HERE_H

#include "set_env.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* For cmocka_run_group_tests(), or called by what is given to it. */
static inline int find_bridges(void **state)
{
    char self[4096] = "", beside[4200];
    if (readlink("/proc/self/exe", self, sizeof self - 1) < 0)
        return -1;
    *strrchr(self, '/') = '\0';
    snprintf(beside, sizeof beside, "%s/..", self);
    const bool named = getenv("GLAREPP_BRIDGES") != NULL;
    return set_env(named ? NULL : "GLAREPP_BRIDGES", beside);
}

#endif
