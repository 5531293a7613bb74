#include "sun/flare_item.h"

#include "core/parallel.h"

#include <stddef.h>

enum { ROWS = 16 }; // of a task

struct adding {
    const struct gp_flare_items *items;
    const struct gp_light *light;
    struct gp_rect frame;
    struct gp_planes *layer;
};

static void add_item_rows(const struct adding *a,
                          const struct gp_flare_item *item, int y0, int y1)
{
    const float visible = (float) a->light[item->light].visibility;
    const struct gp_rect f = a->frame;
    for (int y = y0; y < y1; y++) {
        int x0, x1;
        if (!gp_flare_span(item, y, y + 1, &x0, &x1))
            continue;
        const size_t at = (size_t) (y - f.y0) * (size_t) gp_rect_w(f) +
                          (size_t) (x0 - f.x0);
        for (int c = 0; c < 3; c++) {
            if (item->amount[c] != 0.0f)
                gp_flare_row(item, c, y, x0, x1, item->amount[c] * visible,
                             a->layer->c[c] + at);
        }
    }
}

static void add_rows(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const int y0 = a->frame.y0 + i * ROWS;
    const int y1 = a->frame.y1 - y0 < ROWS ? a->frame.y1 : y0 + ROWS;
    (void) thread;
    for (int k = 0; k < a->items->n; k++) {
        const struct gp_flare_item *const item = &a->items->at[k];
        if (item->rect.y0 < y1 && item->rect.y1 > y0)
            add_item_rows(a, item, y0, y1);
    }
}

gp_status gp_flare_add(const struct gp_log *log, const struct gp_flare *f,
                       const struct gp_light *light, int n,
                       struct gp_rect frame, struct gp_rect display,
                       struct gp_planes *layer)
{
    struct gp_flare_items items = {0};
    gp_status st = gp_flare_items_make(log, f, light, n, true, frame,
                                       display, &items);
    if (!st && items.n > 0) {
        struct adding a = {&items, light, frame, layer};
        gp_parallel_do((gp_rect_h(frame) + ROWS - 1) / ROWS, add_rows, &a);
    }
    gp_flare_items_free(&items);
    return st;
}
