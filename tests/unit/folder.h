// SPDX-License-Identifier: Apache-2.0
/* A folder for the files of a suite: make_folder() and remove_folder() are its
 * setup and teardown. */
#ifndef GP_TESTS_FOLDER_H
#define GP_TESTS_FOLDER_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char folder[64] __attribute__((unused));
static char path[256] __attribute__((unused));

/* That name in the folder, which stays `path` until the next call. */
static inline const char *in_folder(const char *name)
{
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline int make_folder(void **state)
{
    strcpy(folder, "/tmp/glarepp-test-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static inline int remove_folder(void **state)
{
    char command[96];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

#endif
