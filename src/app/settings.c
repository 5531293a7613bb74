#include "app/settings.h"

#include "core/memory.h"

const struct gp_settings gp_defaults = {
    .read = GP_READ_DEFAULTS,
    .sensor = GP_SENSOR_DEFAULTS,
    .kernel = GP_KERNEL_DEFAULTS,
    .glare = GP_GLARE_DEFAULTS,
    .compose = GP_COMPOSE_DEFAULTS,
    .tone = GP_TONE_DEFAULTS,
    .write = GP_WRITE_DEFAULTS,
    .bench = GP_BENCH_DEFAULTS,
    .compare = GP_COMPARE_DEFAULTS,
    .sun = GP_SUN_SETTINGS_DEFAULTS,
    .command = GP_COMMAND_MAIN,
    .level = GP_LEVEL_WARN,
};

/* The lists of words. */
enum { LISTS = 4 };
static struct gp_texts *list_of(struct gp_settings *s, int i)
{
    struct gp_texts *const list[LISTS] = {
        &s->inputs, &s->outputs, &s->ocio_context, &s->light_groups,
    };
    return list[i];
}

gp_status gp_settings_make(const struct gp_log *log, int words,
                           struct gp_settings *s)
{
    *s = gp_defaults;
    for (int i = 0; i < LISTS; i++) {
        void *block;
        gp_status st = gp_alloc(log, "command line", (size_t) words + 1,
                                sizeof(char *), &block);
        if (st)
            return st;
        list_of(s, i)->at = block;
    }
    return GP_OK;
}

void gp_settings_free(struct gp_settings *s)
{
    for (int i = 0; i < LISTS; i++) {
        struct gp_texts *const list = list_of(s, i);
        GP_FREE(list->at);
        list->n = 0;
    }
}
