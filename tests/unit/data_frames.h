/* The EXR frames of the data folder, in order of their names; none without it. */
#ifndef GP_TESTS_DATA_FRAMES_H
#define GP_TESTS_DATA_FRAMES_H

#include "bridge_here.h"
#include "unit.h"

#include <ftw.h>

static char *data_frame[1000];
static int data_frames;

static inline int collect_frame(const char *found, const struct stat *info,
                                int type, struct FTW *at)
{
    const char *const dot = strrchr(found + at->base, '.');
    (void) info;
    if (type == FTW_F && dot && strcmp(dot, ".exr") == 0 &&
        data_frames < (int) COUNT(data_frame) && !strstr(found, "/damaged/"))
        data_frame[data_frames++] = strdup(found);
    return 0;
}

static inline int compare_names(const void *a, const void *b)
{
    return strcmp(*(char *const *) a, *(char *const *) b);
}

/* Lists them, and finds the bridges; setup and teardown of a group. */
static inline int list_data_frames(void **state)
{
    nftw(data_path(""), collect_frame, 16, FTW_PHYS);
    qsort(data_frame, (size_t) data_frames, sizeof *data_frame, compare_names);
    return find_bridges(state);
}

static inline int free_data_frames(void **state)
{
    while (data_frames > 0)
        free(data_frame[--data_frames]);
    return 0;
}

#endif
