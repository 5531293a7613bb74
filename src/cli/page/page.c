// SPDX-License-Identifier: Apache-2.0
#include "cli/page/page.h"

#include "cli/words.h"
#include "core/json.h"
#include "core/memory.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t gp_page_room(const struct gp_settings *s, int pictures)
{
    // names and figures of a picture take up to about this
    static const double TEXT = 4096.0, LEAST = 1024.0;
    const double page =
        (double) strlen(gp_page_before) + (double) strlen(gp_page_after);
    const double pairs =
        gp_option_given(s, "html-size") ? 1.0 : fmax(pictures / 2.0, 1.0);
    const double room =
        1e6 * s->page.megabytes * pairs - page - TEXT * pictures;
    return (size_t) (room > LEAST ? room : LEAST);
}

gp_status gp_page_make(const struct gp_log *log, const struct gp_settings *s,
                       const char *kind, const char *title, json_t **out)
{
    const struct gp_texts *const in = &s->input.files;
    char *command = NULL;
    const gp_status st =
        gp_command_text(log, s, in->at, in->n, GP_COMMAND_ALL, &command);
    if (!st)
        *out = json_pack("{ss so ss so so}", "kind", kind, "title",
                         gp_json_name(title), "version", GP_VERSION, "command",
                         gp_json_name(command), "entries", json_array());
    free(command);
    return st;
}

/* Writes JSON within a script element: no "<" may end it, or begin another. */
static gp_status write_json(struct gp_file *f, const char *text)
{
    static const char less[] = "\\u003c";
    gp_status st = GP_OK;
    while (*text && !st) {
        const size_t n = strcspn(text, "<");
        st = gp_file_write(f, text, n);
        text += n;
        if (*text == '<' && !st) {
            st = gp_file_write(f, less, sizeof less - 1);
            text++;
        }
    }
    return st;
}

gp_status gp_page_save(const struct gp_log *log, const struct gp_settings *s,
                       const char *path, json_t *page)
{
    char *const text =
        gp_json_print(page, JSON_COMPACT | JSON_REAL_PRECISION(9));
    struct gp_file *f = NULL;
    gp_status st = text ? GP_OK : gp_no_memory(log, path);
    GP_TRY(st);
    GP_TRY(gp_file_open(log, path, false, false, &f));
    GP_TRY(gp_file_write(f, gp_page_before, strlen(gp_page_before)));
    GP_TRY(write_json(f, text));
    GP_TRY(gp_file_write(f, gp_page_after, strlen(gp_page_after)));
    st = gp_file_commit(&f);
    const double size = 1e-6 * (double) (strlen(gp_page_before) + strlen(text) +
                                         strlen(gp_page_after));
    if (!st && gp_option_given(s, "html-size") && size > s->page.megabytes)
        gp_say(log, GP_LEVEL_WARN,
               "%s: %.2g MB, over --html-size, by names and figures; make a "
               "page of fewer frames",
               path, size);
out:
    gp_file_discard(&f);
    free(text);
    return st;
}
