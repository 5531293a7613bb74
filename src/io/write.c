#include "io/write.h"

#include "core/memory.h"
#include "io/file.h"
#include "io/io_priv.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <stdio.h>
#include <string.h>

enum { ENDING_BYTES = 16 };

/* Finds the ending that chooses the format; returns true when it is that of
 * --stdout-format, for stdout, pipes and devices without an ending. */
static bool find_ending(const struct gp_write_params *p, const char *path,
                        char ending[ENDING_BYTES])
{
    static const char *const formats[] = {
#define X(name, ending, text) ending,
        GP_STDOUT_LIST(X)
#undef X
    };
    gp_file_ending(path, ending, ENDING_BYTES);
    if (ending[0] || !gp_file_is_straight(path))
        return false;
    strcpy(ending, formats[p->stdout_format]);
    return true;
}

// -- writers ------------------------------------------------------------------

/* DWA is packed by OpenImageIO. */
static gp_status check_exr(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const char *ending)
{
    (void) ending;
    return p->compression < GP_COMPRESSION_DWAA ? GP_OK
                                                : gp_oiio_check(log, path);
}

static void add_ending(const char *ending, char *list, size_t size, size_t *n)
{
    const int wrote = snprintf(list + *n, size - *n, "%s.%s", *n ? ", " : "",
                               ending);
    *n = wrote > 0 && (size_t) wrote < size - *n ? *n + (size_t) wrote
                                                 : size - 1;
}

/* Refuses what no writer takes; the line lists the endings that one takes. */
static gp_status check_other(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const char *ending)
{
    char list[256] = "";
    size_t n = 0;
    if (gp_oiio_writes(ending))
        return gp_oiio_picture_check(log, p, path, ending);
    for (const struct gp_writer *w = gp_writers; w->ending; w++) {
        if (!w->only_straight)
            add_ending(w->ending, list, sizeof list, &n);
    }
    for (int i = 0; gp_oiio_ending(i); i++)
        add_ending(gp_oiio_ending(i), list, sizeof list, &n);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: unknown format (ending %s%s); end the name in one of "
                   "%s", path, ending[0] ? "." : "is missing", ending, list);
}

static gp_status write_oiio(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats)
{
    char ending[ENDING_BYTES];
    (void) stats;
    (void) find_ending(p, path, ending);
    gp_status st = check_other(log, p, path, ending);
    return st ? st : gp_oiio_picture_write(log, p, path, ending, f, planes,
                                           kind);
}

/* Raw frames go to streams only: files called .raw are cameras'. */
const struct gp_writer gp_writers[] = {
    {"exr", false, true, check_exr, gp_exr_write_picture},
    {"png", false, true, NULL, gp_png_write},
    {"pfm", false, false, NULL, gp_pfm_write},
    {"raw", true, false, NULL, gp_raw_write},
    {NULL, false, false, check_other, write_oiio}, // by its ending
};

static const struct gp_writer *find_writer(const struct gp_write_params *p,
    const char *path, char ending[ENDING_BYTES])
{
    const bool straight = find_ending(p, path, ending);
    const struct gp_writer *w = gp_writers;
    while (w->ending && (strcmp(w->ending, ending) != 0 ||
                         (w->only_straight && !straight)))
        w++;
    return w;
}

bool gp_write_has_alpha(const struct gp_write_params *p, const char *path)
{
    char ending[ENDING_BYTES];
    const struct gp_writer *const w = find_writer(p, path, ending);
    return w->ending ? w->alpha : gp_oiio_has_alpha(ending);
}

gp_status gp_write_hdr_check(const struct gp_log *log,
    const struct gp_write_params *p, const char *keeps, const char *path)
{
    char ending[ENDING_BYTES];
    const bool straight = find_ending(p, path, ending);
    if (straight && strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
            "%s: %s, which only EXR can (found --stdout-format %s); give it a "
            "file", path, keeps, ending);
    if (strcmp(ending, "exr") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %s, which only EXR can (ending %s); end the name "
                       "in .exr", path, keeps, ending[0] ? ending : "missing");
    return gp_write_check(log, p, path);
}

bool gp_write_would_overwrite(const struct gp_write_params *p, const char *path)
{
    return p->no_clobber && strcmp(path, "-") != 0 && gp_file_exists(path);
}

gp_status gp_write_check(const struct gp_log *log,
                         const struct gp_write_params *p, const char *path)
{
    char ending[ENDING_BYTES];
    const struct gp_writer *const w = find_writer(p, path, ending);
    gp_status st = w->check ? w->check(log, p, path, ending) : GP_OK;
    return st ? st : gp_file_check(log, path, p->create_dir);
}

gp_status gp_write_picture(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats)
{
    char ending[ENDING_BYTES];
    if (gp_write_would_overwrite(p, path))
        return GP_OK;
    return find_writer(p, path, ending)->write(log, p, path, f, planes, kind,
                                               stats);
}

gp_status gp_write_hdr(const struct gp_log *log,
    const struct gp_write_params *p, const char *path,
    const struct gp_hdr_colour *set, int n, struct gp_write_stats *stats)
{
    gp_status st = gp_write_hdr_check(log, p, GP_HDR_KEEPS, path);
    if (st || gp_write_would_overwrite(p, path))
        return st;
    return gp_exr_write_hdr(log, p, path, set, n, stats);
}

static void *take_memory(size_t bytes)
{
    void *block;
    return gp_alloc(NULL, "libdeflate", bytes, 1, &block) ? NULL : block;
}

void gp_write_keep_memory(void)
{
    libdeflate_set_memory_allocator(take_memory, gp_free);
}
