// SPDX-License-Identifier: Apache-2.0
/* Lists of frames and of views, and patterns of names: the first line is a list
 * of frames, the others are names. */
#include "harness.h"
#include "io/sequence.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

static void check_list(const char *text)
{
    struct gp_frames f = {0};
    if (fuzz_line(gp_frames_parse(&fuzz_log, text, &f)))
        return;
    if (f.n < 1 || f.n > GP_FRAME_LIST_MAX)
        abort();
    fuzz_touch(f.number, (size_t) f.n * sizeof *f.number);
    gp_frames_free(&f);
}

/* A list of views has names that are not empty, and no two the same. */
static void check_views(const char *text)
{
    struct gp_views v = {0};
    if (fuzz_line(gp_views_parse(&fuzz_log, text, &v)))
        return;
    if (v.n < 1)
        abort();
    for (int i = 0; i < v.n; i++) {
        if (!v.name[i][0] || strchr(v.name[i], '/') ||
            (i > 0 && strcmp(v.name[i], v.name[i - 1]) == 0))
            abort();
    }
    gp_views_free(&v);
}

/* A frame's name is the pattern with the number in its place. */
static void check_number(const struct gp_pattern *p, const char *text,
                         const char *name, int number)
{
    if (memcmp(name, text, p->at) != 0)
        abort();
    char *end = (char *) name + p->at;
    const long n = p->len ? strtol(end, &end, 10) : number;
    const char *const tail = text + p->at + p->len;
    if (strcmp(end, tail) != 0 && !isdigit((unsigned char) *tail))
        abort();
    if (n != number && !isdigit((unsigned char) *tail))
        abort();
}

static void check_name(const char *text)
{
    static const int number[] = {0, 7, 1001, 999999999, -1, -999999999};
    struct gp_pattern p;
    int back;
    gp_frame_number(text, &back);
    check_views(text);
    if (fuzz_line(gp_pattern_find(&fuzz_log, text, &p)))
        return;
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) {
        char *const name = gp_pattern_name(&p, number[i],
                                           p.views ? "left" : NULL);
        if (!name)
            abort();
        // with views: 2 signs become a letter or 4
        const size_t most = strlen(text) + 2 * (size_t) p.views + 16;
        if (p.views && strlen(name) > most)
            abort();
        if (!p.views)
            check_number(&p, text, name, number[i]);
        gp_frame_number(name, &back);
        free(name);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *const text = malloc(size + 1);
    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    char *rest = text;
    fuzz_begin();
    check_list(strsep(&rest, "\n"));
    while (rest)
        check_name(strsep(&rest, "\n"));
    fuzz_end(FUZZ_FIXED);
    free(text);
    return 0;
}
