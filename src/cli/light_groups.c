// SPDX-License-Identifier: Apache-2.0
/* The words of --light-group. */
#include "cli/options.h"

#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

/* Cuts a word of --light-group into its parts; false: they are none. A kernel ends
 * at ",gain=", so that its recipe may have commas. */
static bool cut_group(char *word, struct gp_light_group *out)
{
    char *const k = strstr(word, ":kernel="), *const g = strstr(word, ":gain=");
    char *at = !k || (g && g < k) ? g : k, *end;
    bool gain = false;
    *out = (struct gp_light_group) {.name = word, .gain = 1.0f};
    if (at == word)
        return false;
    for (; at; at = end) {
        *at++ = '\0'; // of what is before
        const bool kernel = strncmp(at, "kernel=", 7) == 0;
        if (kernel ? out->kernel != NULL : gain || strncmp(at, "gain=", 5) != 0)
            return false;
        if (kernel) {
            out->kernel = at + 7;
            end = strstr(at, ",gain=");
            continue;
        }
        gain = true;
        out->gain = strtof(at + 5, &end);
        if (end == at + 5 || (*end && *end != ',') ||
            !(out->gain >= 0.0f && out->gain <= 1e6f))
            return false;
        end = *end ? end : NULL;
    }
    return !out->kernel || *out->kernel;
}

gp_status gp_light_groups_read(const struct gp_log *log, struct gp_settings *s)
{
    const struct gp_texts *const words = &s->input.light_groups;
    gp_status st;
    if (!words->n)
        return GP_OK;
    GP_TRY(gp_alloc_zero(log, "light groups", (size_t) words->n,
                         sizeof *s->input.group, &s->input.group));
    for (int i = 0; i < words->n; i++) {
        struct gp_light_group *const g = &s->input.group[i];
        char *const word = gp_strdup(words->at[i]);
        if (!word)
            return gp_no_memory_bare(log, "light groups");
        if (!cut_group(word, g))
            return gp_fail(log, GP_ERR_USAGE,
                           "--light-group: not a layer with "
                           "a kernel or gain (found \"%s\"); write "
                           "NAME:kernel=star,gain=2, with a gain of 0 to 1e6",
                           words->at[i]);
        // of more kernels than the only --kernel
        const struct gp_texts *const own = &s->kernel.words;
        struct gp_texts *const more = &s->input.group_kernels;
        if (g->kernel && (own->n != 1 || strcmp(own->at[0], g->kernel) != 0 ||
                          gp_kernel_is_file(g->kernel))) {
            int k = 0;
            while (k < more->n && strcmp(more->at[k], g->kernel) != 0)
                k++;
            if (k == more->n)
                more->at[more->n++] = g->kernel;
            g->more = 1 + k;
        }
        for (int k = 0; k < i; k++) {
            if (strcmp(g->name, s->input.group[k].name) == 0)
                GP_TRY(gp_fail(log, GP_ERR_USAGE,
                               "--light-group: a layer is "
                               "there twice (found %s); name it once",
                               g->name));
        }
        for (int k = 0; k < GP_PART_NAMES && s->output.parts.n; k++) {
            if (strcmp(g->name, gp_part_names[k]) == 0)
                GP_TRY(gp_fail(log, GP_ERR_USAGE,
                               "--parts: it has a layer %s of "
                               "its own; give the light group another name",
                               g->name));
        }
    }
out:
    return st;
}
