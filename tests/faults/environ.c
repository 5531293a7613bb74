// SPDX-License-Identifier: Apache-2.0
/* Tells of variables that are added to the environment: LD_PRELOAD this.
 *
 *   ENVIRON_LOG=FILE  gets a line "added NAME" for each, and "beside-threads
 *                     NAME" where other threads were running: the environment
 *                     moves under those that read it
 */
#include <dlfcn.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool several_threads(void)
{
    char line[256];
    long threads = 0;
    FILE *const f = fopen("/proc/self/status", "r");
    while (f && threads == 0 && fgets(line, sizeof line, f))
        sscanf(line, "Threads: %ld", &threads);
    if (f)
        fclose(f);
    return threads > 1;
}

/* The name ends at a "=" or with the text. */
static void tell(const char *name)
{
    char key[100], line[128];
    const char *const path = getenv("ENVIRON_LOG");
    snprintf(key, sizeof key, "%.*s", (int) strcspn(name, "="), name);
    if (!path || getenv(key)) // an old variable changes in its place
        return;
    const int n = snprintf(line, sizeof line, "%s %s\n",
                           several_threads() ? "beside-threads" : "added", key);
    const int fd = open(path, O_WRONLY | O_CREAT | O_APPEND, 0666);
    if (fd < 0 || write(fd, line, (size_t) n) != n)
        abort();
    close(fd);
}

#define NEXT(name) ((__typeof__(&name)) dlsym(RTLD_NEXT, #name))

int setenv(const char *name, const char *value, int overwrite)
{
    tell(name);
    return NEXT(setenv)(name, value, overwrite);
}

int putenv(char *setting)
{
    tell(setting);
    return NEXT(putenv)(setting);
}
