/* Names of files: descriptors that they stand for, links, folders, endings. */
#include "io/file.h"

#include "core/memory.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { LINKS = 40 }; // as many as the system follows

/* Returns where the last component starts. */
static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Copies the folder of a path with all links followed; "" when it does not
 * exist. */
static void real_folder(const char *path, char real[PATH_MAX])
{
    char folder[PATH_MAX];
    const size_t n = (size_t) (base_of(path) - path);
    snprintf(folder, sizeof folder, "%.*s", n ? (int) n : 1, n ? path : ".");
    if (n >= sizeof folder || !realpath(folder, real))
        real[0] = '\0';
}

/* Returns the descriptor that `path` names by itself, its last component being
 * in the folder `real`; -1 for other names. */
static int named_descriptor(const char *path, const char *real)
{
    static const char digits[] = "0123456789", task[] = "/task/";
    char own[PATH_MAX], *end;
    const char *const number = base_of(path);
    const long fd = strtol(number, &end, 10);
    if (!strchr(digits, *number) || end == number || *end || fd > INT_MAX ||
        !realpath("/proc/self", own) ||
        strncmp(real, own, strlen(own)) != 0)
        return -1;
    real += strlen(own);
    if (strncmp(real, task, strlen(task)) == 0) // of one thread
        real += strlen(task) + strspn(real + strlen(task), digits);
    return strcmp(real, "/fd") == 0 ? (int) fd : -1;
}

/* Replaces a link by its target, seen from where the link is seen from; false
 * with errno for other names. */
static bool follow(char at[PATH_MAX])
{
    char to[PATH_MAX];
    const ssize_t n = readlink(at, to, sizeof to);
    if (n <= 0)
        return false;
    const size_t folder = to[0] == '/' ? 0 : (size_t) (base_of(at) - at);
    if (folder + (size_t) n >= PATH_MAX) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(at + folder, to, (size_t) n);
    at[folder + (size_t) n] = '\0';
    return true;
}

/* Follows the links of a name. Returns its descriptor, or -1; sets *system for
 * one that is, or leads to, a name in /proc, as those in /dev/fd do. */
static int follow_names(const char *path, bool *system)
{
    char at[PATH_MAX], real[PATH_MAX];
    *system = gp_is_dash(path);
    if (gp_is_dash(path))
        return STDOUT_FILENO;
    if (strlen(path) >= sizeof at)
        return -1;
    strcpy(at, path);
    for (int links = 0; links < LINKS; links++) {
        real_folder(at, real);
        *system |= strncmp(at, "/proc/", 6) == 0 ||
                   strncmp(real, "/proc/", 6) == 0;
        const int fd = named_descriptor(at, real);
        if (fd >= 0 || !follow(at))
            return fd;
    }
    return -1;
}

int gp_file_descriptor(const char *path)
{
    bool system;
    return follow_names(path, &system);
}

bool gp_file_is_straight(const char *path)
{
    struct stat s;
    bool system;
    (void) follow_names(path, &system);
    return system || (stat(path, &s) == 0 && !S_ISREG(s.st_mode) &&
                      !S_ISDIR(s.st_mode));
}

char *gp_file_folder(const char *path)
{
    const size_t n = (size_t) (base_of(path) - path);
    char *const folder = gp_strdup(n ? path : ".");
    if (folder)
        folder[n > 1 ? n - 1 : 1] = '\0'; // no slash, but that of the root
    return folder;
}

char *gp_file_resolve(const char *path)
{
    struct stat s;
    char at[PATH_MAX];
    if (strlen(path) >= sizeof at)
        return gp_strdup(path); // which the system refuses
    strcpy(at, path);
    for (int i = 0; lstat(at, &s) == 0 && S_ISLNK(s.st_mode); i++) {
        char *const real = realpath(at, NULL);
        if (real || errno != ENOENT || i >= LINKS || !follow(at))
            return real;
    }
    return gp_strdup(at);
}

int gp_file_make_folders(const char *path)
{
    struct stat s;
    char *folder = gp_file_folder(path);
    int error = folder ? 0 : ENOMEM;
    for (char *p = folder + 1; error == 0; p++) {
        const char keep = *p;
        if (keep != '/' && keep != '\0')
            continue;
        *p = '\0';
        // errno of mkdir(), not of stat(), is the reason
        error = mkdir(folder, 0777) ? errno : 0;
        if (error && stat(folder, &s) == 0 && S_ISDIR(s.st_mode))
            error = 0;
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
