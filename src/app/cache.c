#include "app/cache.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Makes the folders of `path` up to its last slash; user only, as the
 * specification asks. */
static bool make_folders(char *path)
{
    for (char *s = path + 1; (s = strchr(s, '/')); s++) {
        *s = '\0';
        bool made = mkdir(path, 0700) == 0 || errno == EEXIST;
        *s = '/';
        if (!made)
            return false;
    }
    return true;
}

char *gp_cache_file(const char *name)
{
    const char *base = getenv("XDG_CACHE_HOME"), *under = "";
    if (!base || base[0] != '/') {
        base = getenv("HOME");
        under = "/.cache";
    }
    char *path;
    if (!base || base[0] != '/' ||
        asprintf(&path, "%s%s/glarepp/%s", base, under, name) < 0)
        return NULL;
    if (!make_folders(path)) {
        free(path);
        return NULL;
    }
    return path;
}
