/* Lists of views: the gp_views_ part of sequence.h. */
#include "io/sequence.h"

#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

void gp_views_free(struct gp_views *v)
{
    gp_free(v->text);
    gp_free(v->name);
    *v = (struct gp_views) {0};
}

static gp_status check_name(const struct gp_log *log, const char *text,
                            const struct gp_views *v, const char *name)
{
    if (!*name)
        return gp_fail(log, GP_ERR_USAGE,
                       "--views: an empty name (found in \"%s\"); write "
                       "left,right", text);
    if (strchr(name, '/'))
        return gp_fail(log, GP_ERR_USAGE,
                       "--views: a name with a slash (found %s); views are "
                       "names, %%V may stand for a folder", name);
    for (int i = 0; i < v->n; i++) {
        if (strcmp(v->name[i], name) == 0)
            return gp_fail(log, GP_ERR_USAGE,
                           "--views: %s comes twice (found in %s); name each "
                           "view once", name, text);
    }
    return GP_OK;
}

/* Cuts v->text at its commas into at most GP_VIEWS_MAX names. */
static gp_status cut(const struct gp_log *log, const char *text,
                     struct gp_views *v)
{
    for (char *at = v->text; at;) {
        char *const comma = strchr(at, ',');
        if (comma)
            *comma = '\0';
        if (v->n == GP_VIEWS_MAX)
            return gp_fail(log, GP_ERR_USAGE,
                           "--views: too many (over %d); make them in several "
                           "runs", GP_VIEWS_MAX);
        gp_status st = check_name(log, text, v, at);
        if (st)
            return st;
        v->name[v->n++] = at;
        at = comma ? comma + 1 : NULL;
    }
    return GP_OK;
}

gp_status gp_views_parse(const struct gp_log *log, const char *text,
                         struct gp_views *out)
{
    gp_status st;
    void *block;
    struct gp_views v = {0};
    GP_TRY(gp_alloc_zero(log, "view list", GP_VIEWS_MAX, sizeof *v.name,
                         &block));
    v.name = block;
    v.text = gp_strdup(text);
    if (!v.text)
        GP_TRY(gp_fail_bare(log, GP_ERR_BUG, "view list: out of memory"));
    GP_TRY(cut(log, text, &v));
    *out = v;
    return GP_OK;
out:
    gp_views_free(&v);
    return st;
}

gp_status gp_views_check(const struct gp_log *log, const struct gp_pattern *p,
                         const struct gp_views *v)
{
    bool longs = false;
    for (const char *s = p->path; p->views && (s = strchr(s, '%')); s++)
        longs = longs || s[1] == 'V';
    for (int i = 1; p->views && !longs && i < v->n; i++) {
        const size_t n = gp_view_letter(v->name[i]);
        for (int k = 0; k < i; k++) {
            if (strncmp(v->name[i], v->name[k], n) == 0)
                return gp_fail(log, GP_ERR_USAGE,
                               "%s: %%v is the same letter for two views "
                               "(found %s and %s); write %%V", p->path,
                               v->name[k], v->name[i]);
        }
    }
    return GP_OK;
}
