#include "io/file_name.h"

#include "core/memory.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    NAME_BYTES = 255, // of one path component, on all usual systems
    LINK_BYTES = 4096,
    LINKS = 40, // as many as the system follows
};

static bool starts(const char *s, const char *with)
{
    return strncmp(s, with, strlen(with)) == 0;
}

bool gp_file_is_straight(const char *path)
{
    struct stat s;
    if (strcmp(path, "-") == 0 || starts(path, "/dev/fd/") ||
        starts(path, "/dev/std") || starts(path, "/proc/"))
        return true;
    return stat(path, &s) == 0 && !S_ISREG(s.st_mode) && !S_ISDIR(s.st_mode);
}

/* Where the last component starts. */
static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

char *gp_file_folder(const char *path)
{
    size_t n = (size_t) (base_of(path) - path);
    if (n == 0)
        return gp_strdup(".");
    if (n > 1)
        n--; // not the slash, unless it is the root
    char *folder = malloc(n + 1);
    if (folder) {
        memcpy(folder, path, n);
        folder[n] = '\0';
    }
    return folder;
}

/* What the link `path` says, seen from where `path` is seen from; NULL with
 * errno. */
static char *follow(const char *path)
{
    char to[LINK_BYTES];
    const ssize_t n = readlink(path, to, sizeof to);
    if (n == sizeof to)
        errno = ENAMETOOLONG;
    if (n < 0 || n == sizeof to)
        return NULL;
    const size_t folder = to[0] == '/' ? 0 : (size_t) (base_of(path) - path);
    char *next = malloc(folder + (size_t) n + 1);
    if (next) {
        memcpy(next, path, folder);
        memcpy(next + folder, to, (size_t) n);
        next[folder + (size_t) n] = '\0';
    }
    return next;
}

char *gp_file_resolve(const char *path)
{
    struct stat s;
    char *at = gp_strdup(path);
    for (int i = 0; at && lstat(at, &s) == 0 && S_ISLNK(s.st_mode); i++) {
        char *next = realpath(at, NULL);
        if (!next && errno == ENOENT && i < LINKS)
            next = follow(at);
        const int error = errno;
        gp_free(at);
        at = next;
        errno = error;
    }
    return at;
}

char *gp_file_temp_name(const char *path, int nth)
{
    const char *base = base_of(path);
    const long pid = (long) getpid();
    char tail[48];
    int tail_bytes = nth ? snprintf(tail, sizeof tail, ".%ld-%d.tmp", pid, nth)
                         : snprintf(tail, sizeof tail, ".%ld.tmp", pid);
    int name_bytes = NAME_BYTES - 1 - tail_bytes;
    if (strlen(base) < (size_t) name_bytes)
        name_bytes = (int) strlen(base);
    size_t size = (size_t) (base - path) + NAME_BYTES + 1;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%.*s%s", (int) (base - path), path,
                 name_bytes, base, tail);
    return name;
}

/* 0 where the folder is there afterwards, else the errno of mkdir(): what
 * stat() says of a folder that could not be made is not why. */
static int make_folder(const char *path)
{
    struct stat s;
    if (mkdir(path, 0777) == 0)
        return 0;
    const int error = errno;
    return stat(path, &s) == 0 && S_ISDIR(s.st_mode) ? 0 : error;
}

int gp_file_make_folders(const char *path)
{
    char *folder = gp_file_folder(path);
    int error = folder ? 0 : ENOMEM;
    for (char *p = folder + 1; error == 0; p++) {
        const char keep = *p;
        if (keep != '/' && keep != '\0')
            continue;
        *p = '\0';
        error = make_folder(folder);
        *p = keep;
        if (keep == '\0')
            break;
    }
    gp_free(folder);
    if (error)
        errno = error;
    return error ? -1 : 0;
}

void gp_file_ending(const char *path, char *ending, int room)
{
    const char *base = base_of(path);
    const char *dot = strrchr(base, '.');
    ending[0] = '\0';
    if (!dot || dot == base || strlen(dot + 1) >= (size_t) room)
        return;
    int n = 0;
    for (const char *c = dot + 1; *c; c++)
        ending[n++] = *c >= 'A' && *c <= 'Z' ? (char) (*c - 'A' + 'a') : *c;
    ending[n] = '\0';
}
